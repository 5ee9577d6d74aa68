#ifndef SINEW_SIM_IMPORT_DETECT_FORMAT_H_
#define SINEW_SIM_IMPORT_DETECT_FORMAT_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// The kinds of file that clips come in.
enum class ClipFormat {
  kBvh,
  kAsfAmc,
  kSmplNpz,
  kRobotNpz,
  kDeepMimic,
  kRobotCsv,
  kKeyframes,
  kFbx,
};

// What XML must hold to be a clip: keyframes.
inline constexpr absl::string_view kKeyframeTag = "<key";

// As in v1::ClipSource.format, and as users write it: "bvh", "asf_amc", ...
absl::string_view FormatName(ClipFormat format);

// INVALID_ARGUMENT listing the names if it is none of them.
absl::StatusOr<ClipFormat> FormatOfName(absl::string_view name);

// What a file is, by the signature of its content and, where formats have none,
// the extension of its name. `bytes` may be its beginning alone (64 KiB do, but
// for a model whose keyframes stand behind them).
// INVALID_ARGUMENT naming the file for what is no clip, with what it is instead
// if that is known: a skeleton without motion, a model without keyframes,
// marker positions (C3D), a clip of another body. Pure.
absl::StatusOr<ClipFormat> DetectFormat(const std::string& path,
                                        absl::string_view bytes);

// ".bvh" of "a/B.BVH"; empty if there is none.
std::string LowerCaseExtension(absl::string_view path);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_DETECT_FORMAT_H_
