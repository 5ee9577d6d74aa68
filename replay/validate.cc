#include "replay/validate.h"

#include <cmath>
#include <limits>
#include <optional>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/finite.h"
#include "common/segment/row_episodes.h"
#include "common/segment/segment_layout.h"
#include "common/segment/segment_size.h"
#include "common/segment/state_limits.h"
#include "common/status_macros.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;

// Widths come from the wire: keep products of three factors in range.
constexpr int64_t kMaxFactor = 1 << 20;

template <typename T>
std::optional<std::string> Differs(absl::string_view field, const T& expected,
                                   const T& found) {
  if (expected == found) return std::nullopt;
  return absl::StrCat(field, ": expected ", expected, ", found ", found);
}

absl::Status OutOfRange(const Expectation& expectation, absl::string_view field,
                        absl::string_view expected, int64_t found) {
  return absl::InvalidArgumentError(
      absl::StrCat("open order ", expectation.expected.order_id(), ": ", field,
                   ": expected ", expected, ", found ", found));
}

absl::Status CheckLayout(const Expectation& expectation) {
  const std::string found = LayoutSha256(*expectation.layout);
  if (found != expectation.expected.layout_sha256()) {
    return absl::InvalidArgumentError(
        absl::StrCat("open order ", expectation.expected.order_id(),
                     ": layout_sha256: expected that of the layout, ", found,
                     ", found \"", expectation.expected.layout_sha256(), "\""));
  }
  for (const auto& column : expectation.layout->columns()) {
    int64_t product = 1;
    for (int64_t extent : column.shape()) {
      if (extent < 1 || extent > kMaxFactor || product > kMaxFactor) {
        return OutOfRange(expectation,
                          absl::StrCat("layout column ", column.name()),
                          "extents from 1 to 2^20", extent);
      }
      product *= extent;
    }
  }
  return absl::OkStatus();
}

bool StateIsFinite(const v1::EnvironmentState& state) {
  const auto finite = [](const auto& values) {
    return AllFinite64({reinterpret_cast<const char*>(values.data()),
                        values.size() * sizeof(double)});
  };
  return finite(state.physics()) && finite(state.previous_target()) &&
         std::isfinite(state.episode_return()) &&
         std::isfinite(state.episode_error()) &&
         std::isfinite(state.goal_distance());
}

// All that is said of one start.
bool ResultIsFinite(const v1::EvaluationResult& result) {
  for (double sum : result.sum_body_mm()) {
    if (!std::isfinite(sum)) return false;
  }
  return std::isfinite(result.sum_g_mpjpe_mm()) &&
         std::isfinite(result.sum_mpjpe_mm()) &&
         std::isfinite(result.sum_velocity()) &&
         std::isfinite(result.sum_acceleration());
}

bool SecondsAreFinite(const v1::StageSeconds& seconds) {
  return std::isfinite(seconds.simulate()) && std::isfinite(seconds.infer()) &&
         std::isfinite(seconds.observe()) && std::isfinite(seconds.encode());
}

// Everything outside the columns; nullopt: finite.
std::optional<std::string> NonFiniteField(const v1::Segment& segment) {
  for (int i = 0; i < segment.end_states_size(); ++i) {
    if (!StateIsFinite(segment.end_states(i))) {
      return absl::StrCat("end_states[", i, "]: expected finite numbers");
    }
  }
  for (int i = 0; i < segment.episodes_size(); ++i) {
    if (!std::isfinite(segment.episodes(i).episode_return()) ||
        !std::isfinite(segment.episodes(i).mean_body_distance())) {
      return absl::StrCat("episodes[", i, "]: expected finite numbers");
    }
  }
  for (int i = 0; i < segment.results_size(); ++i) {
    if (!ResultIsFinite(segment.results(i))) {
      return absl::StrCat("results[", i, "]: expected finite numbers");
    }
  }
  if (!SecondsAreFinite(segment.seconds())) {
    return "seconds: expected finite numbers";
  }
  return std::nullopt;
}

bool ColumnsAreFinite(const v1::Segment& segment) {
  for (const v1::Tensor& column : segment.columns()) {
    const bool finite =
        column.dtype() == v1::DATA_TYPE_FLOAT32   ? AllFinite32(column.data())
        : column.dtype() == v1::DATA_TYPE_FLOAT64 ? AllFinite64(column.data())
                                                  : true;
    if (!finite) return false;
  }
  return true;
}

template <typename Items>
std::optional<std::string> BelowZero(absl::string_view field,
                                     const Items& items) {
  for (int i = 0; i < items.size(); ++i) {
    const auto& item = items[i];
    if (item.clip() < 0 || item.start_frame() < 0) {
      return absl::StrCat(field, "[", i,
                          "]: expected clip and start_frame >= 0, found ",
                          item.clip(), " and ", item.start_frame());
    }
  }
  return std::nullopt;
}

// What is wrong whatever the run's limits are, for one that says none; nullopt:
// nothing.
std::optional<std::string> WrongWithoutLimits(const v1::Segment& segment) {
  if (auto text = BelowZero("end_states", segment.end_states())) return text;
  if (auto text = BelowZero("episodes", segment.episodes())) return text;
  if (auto text = BelowZero("results", segment.results())) return text;
  for (int i = 0; i < segment.episodes_size(); ++i) {
    const int32_t steps = segment.episodes(i).steps();
    if (steps >= 1) continue;
    return absl::StrCat("episodes[", i, "].steps: expected >= 1, found ",
                        steps);
  }
  return std::nullopt;
}

// `limits` may be null. nullopt: it is within them.
std::optional<std::string> BeyondLimits(const v1::StateLimits* limits,
                                        const v1::Segment& segment) {
  if (limits == nullptr) return WrongWithoutLimits(segment);
  const absl::Status status = CheckSegment(segment, *limits);
  if (status.ok()) return std::nullopt;
  return std::string(status.message());
}

// Whether a column has a flag for every step of an order.
bool HasFlags(const v1::Segment& segment, absl::string_view name,
              const v1::OpenRequest::Expected& expected) {
  const v1::Tensor* column = FindColumn(segment, name);
  return column != nullptr && column->shape_size() == 2 &&
         column->shape(0) == expected.steps() &&
         column->shape(1) == expected.environments() &&
         static_cast<int64_t>(column->data().size()) ==
             int64_t{expected.steps()} * expected.environments();
}

// Whether the episodes of its environments are as many as its rows ended;
// nullopt: they are, or its layout does not say which rows did.
std::optional<std::string> WrongEpisodes(
    const v1::OpenRequest::Expected& expected, const v1::Segment& segment) {
  if (!HasFlags(segment, column::kTerminated, expected) ||
      !HasFlags(segment, column::kTruncated, expected)) {
    return std::nullopt;
  }
  const absl::Status status = EpisodesOfRows(segment).status();
  if (status.ok()) return std::nullopt;
  return std::string(status.message());
}

// The copied fields; nullopt: as expected.
std::optional<std::string> WrongKey(const Expectation& expectation,
                                    const v1::Segment& segment) {
  const auto& expected = expectation.expected;
  if (auto text = Differs("run_id", expectation.run_id, segment.run_id())) {
    return text;
  }
  if (auto text =
          Differs("order_id", expected.order_id(), segment.order_id())) {
    return text;
  }
  if (auto text =
          Differs("iteration", expected.iteration(), segment.iteration())) {
    return text;
  }
  const bool training = expected.steps() > 0;
  if (!training && segment.columns_size() > 0) {
    return absl::StrCat("columns: expected none of an evaluation, found ",
                        segment.columns_size());
  }
  if (auto text = Differs("number of end_states",
                          training ? expected.environments() : 0,
                          segment.end_states_size())) {
    return text;
  }
  return Differs("number of results", training ? 0 : expected.environments(),
                 segment.results_size());
}

std::optional<std::string> WrongSnapshot(
    const v1::OpenRequest::Expected& expected, const v1::Segment& segment) {
  if (auto text = Differs("snapshot_version", expected.snapshot_version(),
                          segment.snapshot_version())) {
    return text;
  }
  return Differs("snapshot_sha256", expected.snapshot_sha256(),
                 segment.snapshot_sha256());
}

std::optional<std::string> WrongColumns(const Expectation& expectation,
                                        const v1::Segment& segment) {
  const auto& expected = expectation.expected;
  if (auto text = Differs("layout_sha256", expected.layout_sha256(),
                          segment.layout_sha256())) {
    return text;
  }
  const absl::Status status = CheckColumns(
      segment, *expectation.layout, expected.steps(), expected.environments());
  if (!status.ok()) return std::string(status.message());
  return std::nullopt;
}

}  // namespace

absl::Status CheckExpectation(const Expectation& expectation) {
  const auto& expected = expectation.expected;
  if (expected.order_id() < 0) {
    return OutOfRange(expectation, "order_id", ">= 0", expected.order_id());
  }
  if (expected.environments() < 1 || expected.environments() > kMaxFactor) {
    return OutOfRange(expectation, "environments", "1 to 2^20",
                      expected.environments());
  }
  if (expected.steps() < 0 || expected.steps() > kMaxFactor) {
    return OutOfRange(expectation, "steps", "0 to 2^20", expected.steps());
  }
  if (!IsSha256Hex(expected.snapshot_sha256())) {
    return absl::InvalidArgumentError(
        absl::StrCat("open order ", expected.order_id(),
                     ": snapshot_sha256: expected a SHA-256, found \"",
                     expected.snapshot_sha256(), "\""));
  }
  if (expected.steps() == 0) return absl::OkStatus();
  if (expectation.layout == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("open order ", expected.order_id(),
                     ": layout: expected one, since steps is ",
                     expected.steps(), ", found none"));
  }
  return CheckLayout(expectation);
}

int64_t MaxSegmentBytes(const Expectation& expectation) {
  const v1::OpenRequest::Expected& expected = expectation.expected;
  return expected.steps() == 0
             ? MaxEvaluationBytes(expected.environments())
             : MaxTrainingBytes(*expectation.layout, expected.environments(),
                                expected.steps());
}

Response Refuse(int64_t order_id, Response::Verdict verdict,
                absl::string_view detail) {
  Response response;
  response.set_order_id(order_id);
  response.set_verdict(verdict);
  response.set_detail(std::string(detail));
  return response;
}

Response Judge(const Expectation& expectation, absl::string_view bytes,
               v1::Segment& segment) {
  const int64_t order_id = expectation.expected.order_id();
  if (bytes.size() > std::numeric_limits<int32_t>::max() ||
      !segment.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return Refuse(order_id, Response::VERDICT_MALFORMED,
                  absl::StrCat("expected a Segment, found ", bytes.size(),
                               " bytes that do not parse"));
  }
  if (const auto detail = WrongKey(expectation, segment)) {
    return Refuse(order_id, Response::VERDICT_MALFORMED, *detail);
  }
  if (const auto detail = WrongSnapshot(expectation.expected, segment)) {
    return Refuse(order_id, Response::VERDICT_STALE, *detail);
  }
  if (expectation.expected.steps() > 0) {
    if (const auto detail = WrongColumns(expectation, segment)) {
      return Refuse(order_id, Response::VERDICT_LAYOUT, *detail);
    }
  }
  if (!ColumnsAreFinite(segment)) {
    // The slow scan knows which element it was.
    return Refuse(order_id, Response::VERDICT_NON_FINITE,
                  CheckColumnsFinite(segment).message());
  }
  if (const auto detail = NonFiniteField(segment)) {
    return Refuse(order_id, Response::VERDICT_NON_FINITE, *detail);
  }
  if (const auto detail = BeyondLimits(expectation.limits.get(), segment)) {
    return Refuse(order_id, Response::VERDICT_MALFORMED, *detail);
  }
  if (expectation.expected.steps() > 0) {
    if (const auto detail = WrongEpisodes(expectation.expected, segment)) {
      return Refuse(order_id, Response::VERDICT_MALFORMED, *detail);
    }
  }
  return Refuse(order_id, Response::VERDICT_ACCEPTED, "");
}

}  // namespace sinew::replay
