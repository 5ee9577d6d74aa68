#include "sim/import/formats/read_options.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew::import {
namespace {

template <typename T>
absl::Status Error(absl::string_view field, absl::string_view expected,
                   const T& found) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected ", expected, ", found ", found));
}

}  // namespace

absl::Status CheckReadOptions(const ReadOptions& options) {
  const double unit = options.metres_per_unit.value_or(1);
  if (!(unit > 0 && unit <= 1e6)) {
    return Error("metres_per_unit", "more than 0 and at most 1e6", unit);
  }
  const char axis = options.up_axis.value_or('z');
  if (axis != 'x' && axis != 'y' && axis != 'z') {
    return Error("up_axis", "x, y or z", std::string(1, axis));
  }
  const double rate = options.frames_per_second.value_or(1);
  if (!(rate > 0 && rate <= kMaxFramesPerSecond)) {
    return Error("frames_per_second",
                 absl::StrCat("more than 0 and at most ", kMaxFramesPerSecond),
                 rate);
  }
  const std::string order = options.quaternion_order.value_or("wxyz");
  if (order != "wxyz" && order != "xyzw") {
    return Error("quaternion_order", "wxyz or xyzw", order);
  }
  return absl::OkStatus();
}

}  // namespace sinew::import
