#include "common/policy/validate_taps.h"

#include <set>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/policy/graph_error.h"
#include "common/status_macros.h"

namespace sinew::policy::internal {
namespace {

using Widths = std::map<std::string, int64_t>;
using Shapes = std::map<std::string, std::vector<int64_t>>;

absl::StatusOr<int64_t> WidthOfValue(absl::string_view field,
                                     const std::string& value,
                                     const Widths& widths) {
  const auto found = widths.find(value);
  if (found != widths.end()) return found->second;
  return Bad(field, ": expected an input or a node, found ", Quoted(value));
}

absl::Status CheckGaussian(const v1::GaussianTap& gaussian, int64_t width,
                           const Shapes& shapes, const Widths& widths) {
  SINEW_ASSIGN_OR_RETURN(
      const int64_t mean_width,
      WidthOfValue("gaussian.mean", gaussian.mean(), widths));
  if (mean_width != width) {
    return Bad("gaussian.mean: expected width ", width, ", found ", mean_width);
  }
  const auto found = shapes.find(gaussian.std_parameter());
  if (found == shapes.end()) {
    return Bad("gaussian.std_parameter: expected a declared parameter, found ",
               Quoted(gaussian.std_parameter()));
  }
  if (found->second != std::vector<int64_t>{width}) {
    return Bad("gaussian.std_parameter: expected shape [", width, "], found [",
               absl::StrJoin(found->second, ", "), "]");
  }
  return absl::OkStatus();
}

absl::Status CheckCategorical(const v1::CategoricalTap& categorical,
                              int64_t width, const Widths& widths) {
  SINEW_ASSIGN_OR_RETURN(
      const int64_t logits,
      WidthOfValue("categorical.logits", categorical.logits(), widths));
  int64_t sum = 0;
  for (const int32_t classes : categorical.classes()) {
    if (classes < 2) {
      return Bad("categorical.classes: expected >= 2, found ", classes);
    }
    sum += classes;
  }
  if (sum != logits) {
    return Bad("categorical.classes: expected a sum of ", logits,
               " (the width of the logits), found ", sum);
  }
  if (categorical.classes_size() != width) {
    return Bad("value: expected one index for each of ",
               categorical.classes_size(), " categoricals, found width ",
               width);
  }
  return absl::OkStatus();
}

absl::Status CheckTap(const v1::Tap& tap, const Shapes& shapes,
                      const Widths& widths) {
  SINEW_ASSIGN_OR_RETURN(const int64_t width,
                         WidthOfValue("value", tap.value(), widths));
  if (tap.decision_period() < 0) {
    return Bad("decision_period: expected >= 0, found ", tap.decision_period());
  }
  switch (tap.distribution_case()) {
    case v1::Tap::kGaussian:
      return CheckGaussian(tap.gaussian(), width, shapes, widths);
    case v1::Tap::kCategorical:
      return CheckCategorical(tap.categorical(), width, widths);
    case v1::Tap::DISTRIBUTION_NOT_SET:
      return absl::OkStatus();
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckName(absl::string_view name) {
  constexpr size_t kLongest = 200;
  bool good = !name.empty() && name.size() <= kLongest;
  for (const char c : name) {
    good &=
        absl::ascii_isalnum(c) || c == '_' || c == '.' || c == '-' || c == '/';
  }
  if (good) return absl::OkStatus();
  return Bad(
      "expected a name of letters, digits, \"_\", \".\", \"-\" and "
      "\"/\", found ",
      Quoted(name));
}

absl::Status CheckTaps(const v1::Graph& graph, const Shapes& shapes,
                       const Widths& widths) {
  std::set<std::string> names;
  for (const v1::GraphInput& input : graph.inputs()) names.insert(input.name());
  int executed = 0;
  for (const v1::Tap& tap : graph.taps()) {
    SINEW_RETURN_IF_ERROR(At("tap", CheckName(tap.name())));
    const std::string where = absl::StrCat("tap ", tap.name());
    if (!names.insert(tap.name()).second) {
      return Bad(where, ": another tap or an input has this name");
    }
    SINEW_RETURN_IF_ERROR(At(where, CheckTap(tap, shapes, widths)));
    if (tap.executed() && ++executed > 1) {
      return Bad(where, ": expected at most one executed tap, found two");
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::policy::internal
