#include "sim/import/read_clip.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/import/detect_format.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/bvh.h"
#include "sim/import/formats/deepmimic.h"
#include "sim/import/formats/fbx.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/keyframes.h"
#include "sim/import/formats/quaternion_order.h"
#include "sim/import/formats/robot_csv.h"
#include "sim/import/formats/robot_layout.h"
#include "sim/import/formats/smpl_npz.h"

namespace sinew::import {
namespace {

absl::StatusOr<ClipFormat> FormatOf(const std::string& path,
                                    absl::string_view bytes,
                                    const ReadClipOptions& options) {
  if (!options.format.empty()) return FormatOfName(options.format);
  return DetectFormat(path, bytes);
}

// The skeleton of an AMC file.
absl::StatusOr<std::string> FindAsf(const std::string& path,
                                    const ReadClipOptions& options) {
  if (!options.asf.empty()) {
    if (FileExists(options.asf)) return options.asf;
    return absl::NotFoundError(absl::StrCat(options.asf, ": no such file"));
  }
  const std::vector<std::string> candidates = AsfCandidates(path);
  for (const std::string& candidate : candidates) {
    if (FileExists(candidate)) return candidate;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      path,
      ": expected the skeleton of its subject (.asf) beside it or given "
      "(--asf), found none",
      candidates.empty()
          ? ""
          : absl::StrCat("; looked for ", absl::StrJoin(candidates, ", "))));
}

absl::StatusOr<Source> ReadAmc(const std::string& path, absl::string_view bytes,
                               absl::string_view name,
                               const ReadClipOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const std::string asf_path, FindAsf(path, options));
  SINEW_ASSIGN_OR_RETURN(const std::string asf_bytes,
                         ReadFile(asf_path, kAsfMaxBytes));
  SINEW_ASSIGN_OR_RETURN(const AsfSkeleton asf, ParseAsf(asf_bytes, asf_path));
  return ParseAmc(bytes, asf, name, path, options.read);
}

absl::StatusOr<Source> ReadRobotCsv(const std::string& path,
                                    absl::string_view bytes,
                                    absl::string_view name,
                                    const ImportModel* model,
                                    const ReadOptions& options) {
  if (model == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(path,
                     ": a robot's recording, which takes the robot's "
                     "model to be read"));
  }
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::RobotLayout> layouts,
                         KnownRobotLayouts());
  SINEW_ASSIGN_OR_RETURN(RobotClip clip,
                         ParseRobotCsv(bytes, name, path, options, layouts));
  SINEW_RETURN_IF_ERROR(SettleQuaternionOrder(*model->model, &clip));
  return clip;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> CompanionFiles(
    const std::string& path, absl::string_view bytes,
    const ReadClipOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const ClipFormat format,
                         FormatOf(path, bytes, options));
  if (format != ClipFormat::kAsfAmc) return std::vector<std::string>();
  SINEW_ASSIGN_OR_RETURN(const std::string asf, FindAsf(path, options));
  return std::vector<std::string>{asf};
}

absl::StatusOr<Source> ReadClip(const std::string& path,
                                absl::string_view bytes, absl::string_view name,
                                const ImportModel* model,
                                const ReadClipOptions& options) {
  const ReadOptions& read = options.read;
  SINEW_RETURN_IF_ERROR(CheckReadOptions(read));
  SINEW_ASSIGN_OR_RETURN(const ClipFormat format,
                         FormatOf(path, bytes, options));
  switch (format) {
    case ClipFormat::kBvh:
      return ParseBvh(bytes, name, path, read);
    case ClipFormat::kAsfAmc:
      return ReadAmc(path, bytes, name, options);
    case ClipFormat::kSmplNpz:
      return ParseSmplNpz(bytes, name, path, read);
    case ClipFormat::kDeepMimic:
      return ParseDeepMimic(bytes, name, path, read);
    case ClipFormat::kRobotCsv:
      return ReadRobotCsv(path, bytes, name, model, read);
    case ClipFormat::kKeyframes:
      return ParseKeyframes(bytes, name, path, read);
    case ClipFormat::kFbx:
      return ParseFbx(bytes, name, path, read);
    case ClipFormat::kRobotNpz:
      break;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      path,
      ": arrays of a robot's training run (joint_pos, body_pos_w), whose "
      "joints have no names and are in the simulator's own order; give the "
      "recording that they were made from (CSV)"));
}

}  // namespace sinew::import
