#include "teacher/client/answers.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

// Wider than any; keeps products of sizes in range.
constexpr int64_t kWidest = 1 << 20;

absl::Status AsDataLoss(const std::string& peer, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::DataLossError(absl::StrCat(peer, ": ", status.message()));
}

// Copies a field's numbers and looks at them.
absl::Status Read(const std::string& peer, const char* field,
                  const std::string& bytes, int64_t width,
                  absl::Span<double> to) {
  const size_t expected = to.size() * sizeof(double);
  if (bytes.size() != expected) {
    return absl::DataLossError(absl::StrCat(peer, ": ", field, ": expected ",
                                            expected, " bytes, found ",
                                            bytes.size()));
  }
  std::memcpy(to.data(), bytes.data(), expected);
  return AsDataLoss(
      peer, CheckFiniteRows(field, absl::Span<const double>(to), width));
}

absl::Status CheckSame(const char* field, const std::string& expected,
                       absl::string_view expected_of, const std::string& found,
                       const std::string& found_peer) {
  if (found == expected) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(found_peer, ": ", field, ": expected ", expected, " as ",
                   expected_of, " has, found ", found));
}

absl::Status CheckRange(const std::string& peer, const char* field, int64_t low,
                        int64_t high, int64_t found) {
  if (found >= low && found <= high) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      peer, ": ", field, ": expected ", low, " to ", high, ", found ", found));
}

}  // namespace

v1::AnnotateRequest MakeRequest(const v1::DescribeTeacherResponse& teacher,
                                const Rows& rows, int64_t first,
                                int64_t count) {
  const int64_t observation = teacher.observation_width();
  const int64_t action = teacher.action_width();
  v1::AnnotateRequest request;
  request.set_bundle_sha256(teacher.bundle_sha256());
  request.set_rows(static_cast<int32_t>(count));
  request.set_observations(rows.observations.data() + first * observation,
                           count * observation * sizeof(float));
  request.set_bases(rows.bases.data() + first * action,
                    count * action * sizeof(double));
  return request;
}

absl::Status ReadAnswer(const v1::DescribeTeacherResponse& teacher,
                        const v1::AnnotateResponse& answer,
                        const std::string& peer, absl::Span<double> targets,
                        absl::Span<double> spread) {
  constexpr absl::string_view kTeacher = "the teacher that was described";
  SINEW_RETURN_IF_ERROR(
      CheckSame("build", teacher.build(), kTeacher, answer.build(), peer));
  SINEW_RETURN_IF_ERROR(CheckSame("CPU class", teacher.cpu_class(), kTeacher,
                                  answer.cpu_class(), peer));
  const int64_t width = teacher.action_width();
  SINEW_RETURN_IF_ERROR(
      Read(peer, "targets", answer.targets(), width, targets));
  SINEW_RETURN_IF_ERROR(Read(peer, "spread", answer.spread(), width, spread));
  for (const double one : spread) {
    if (one >= 0) continue;
    return absl::DataLossError(
        absl::StrCat(peer, ": spread: expected >= 0, found ", one));
  }
  return absl::OkStatus();
}

absl::Status CheckDescription(const v1::DescribeTeacherResponse& teacher,
                              const std::string& peer) {
  if (teacher.bundle_sha256().empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        peer, ": bundle_sha256: expected the bundle's digest, found none"));
  }
  SINEW_RETURN_IF_ERROR(CheckRange(peer, "observation_width", 1, kWidest,
                                   teacher.observation_width()));
  SINEW_RETURN_IF_ERROR(
      CheckRange(peer, "action_width", 1, kWidest, teacher.action_width()));
  return CheckRange(peer, "max_rows", 1, INT32_MAX, teacher.max_rows());
}

absl::Status CheckAlike(const v1::DescribeTeacherResponse& expected,
                        const std::string& expected_peer,
                        const v1::DescribeTeacherResponse& found,
                        const std::string& found_peer) {
  const auto compare = [&](const char* field, const std::string& a,
                           const std::string& b) {
    return CheckSame(field, a, expected_peer, b, found_peer);
  };
  SINEW_RETURN_IF_ERROR(
      compare("bundle", expected.bundle_sha256(), found.bundle_sha256()));
  SINEW_RETURN_IF_ERROR(compare("build", expected.build(), found.build()));
  SINEW_RETURN_IF_ERROR(
      compare("CPU class", expected.cpu_class(), found.cpu_class()));
  // Functions of the bundle, so only a faulty teacher gets here.
  v1::DescribeTeacherResponse a = expected, b = found;
  for (v1::DescribeTeacherResponse* one : {&a, &b}) {
    one->clear_max_rows();
    one->clear_provenance();  // long, and the bundle's
  }
  return compare("description", a.ShortDebugString(), b.ShortDebugString());
}

}  // namespace sinew::teacher
