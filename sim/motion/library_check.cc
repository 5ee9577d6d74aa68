#include "sim/motion/library_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "google/protobuf/util/json_util.h"
#include "sim/motion/frame_columns.h"

namespace sinew::motion {
namespace {

// Float32 rounding leaves 1e-7; more than this was never a rotation.
constexpr float kNormTolerance = 1e-4F;
// Metres, radians, newton metres and their rates: beyond is no motion.
constexpr float kLargest = 1e6F;

absl::Status Error(absl::string_view source, absl::string_view field,
                   absl::string_view expected, absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": ", field, ": expected ", expected, ", found ", found));
}

template <typename Names>
absl::Status CheckNames(const Names& names, absl::string_view field,
                        absl::string_view source) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) return Error(source, field, "names", "an empty one");
    if (!seen.insert(name).second) {
      return Error(source, field, "unique names",
                   absl::StrCat("\"", name, "\" twice"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckClip(const v1::ClipInfo& clip, int64_t first_frame,
                       int64_t rows_left, absl::string_view source) {
  const std::string field = absl::StrCat("clip \"", clip.name(), "\"");
  if (clip.first_frame() != first_frame) {
    return Error(source, absl::StrCat(field, " first_frame"),
                 absl::StrCat(first_frame), absl::StrCat(clip.first_frame()));
  }
  if (clip.num_frames() < 2) {
    return Error(source, absl::StrCat(field, " num_frames"), "at least 2",
                 absl::StrCat(clip.num_frames()));
  }
  if (clip.num_frames() > rows_left) {
    return Error(source, absl::StrCat(field, " num_frames"),
                 absl::StrCat("at most ", rows_left),
                 absl::StrCat(clip.num_frames()));
  }
  for (const double value :
       {clip.cycle_x(), clip.cycle_y(), clip.cycle_yaw()}) {
    if (!std::isfinite(value)) {
      return Error(source, absl::StrCat(field, " cycle"), "finite numbers",
                   absl::StrCat(value));
    }
  }
  return absl::OkStatus();
}

// Name of the clip that row `row` belongs to, and the row within it.
std::string Where(const v1::MotionLibrary& manifest, int64_t row,
                  absl::string_view tensor) {
  for (const v1::ClipInfo& clip : manifest.clips()) {
    if (row < clip.first_frame() + clip.num_frames()) {
      return absl::StrCat("clip \"", clip.name(), "\" frame ",
                          row - clip.first_frame(), " ", tensor);
    }
  }
  return std::string(tensor);
}

absl::Status CheckShape(const FrameColumn& column,
                        const v1::MotionLibrary& manifest,
                        const FrameTensors& frames, absl::string_view source) {
  const std::string field = absl::StrCat("tensor ", column.name);
  const auto found = frames.find(column.name);
  if (found == frames.end())
    return Error(source, field, "it", "no such tensor");
  const TensorView& tensor = found->second;
  if (tensor.dtype != v1::DATA_TYPE_FLOAT32) {
    return Error(source, field, "DATA_TYPE_FLOAT32",
                 v1::DataType_Name(tensor.dtype));
  }
  const std::vector<int64_t> shape =
      ColumnShape(column, manifest, manifest.num_frames());
  if (tensor.shape != shape) {
    return Error(source, field,
                 absl::StrCat("shape [", absl::StrJoin(shape, ", "), "]"),
                 absl::StrCat("[", absl::StrJoin(tensor.shape, ", "), "]"));
  }
  if (!tensor.aligned()) {
    return Error(source, field, "data at a multiple of 4 bytes",
                 "a header of another length");
  }
  return absl::OkStatus();
}

absl::Status CheckUnit(const FrameColumn& column,
                       const v1::MotionLibrary& manifest,
                       absl::Span<const float> values,
                       absl::string_view source) {
  const int64_t width = RowWidth(column, manifest);
  for (size_t i = 0; i + 4 <= values.size(); i += 4) {
    const float* q = &values[i];
    const float norm =
        std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (std::abs(norm - 1) > kNormTolerance) {
      return Error(
          source, Where(manifest, static_cast<int64_t>(i) / width, column.name),
          "a unit quaternion", absl::StrCat("norm ", norm));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckValues(const FrameColumn& column,
                         const v1::MotionLibrary& manifest,
                         absl::Span<const float> values,
                         absl::string_view source) {
  const int64_t width = RowWidth(column, manifest);
  const float bound = column.kind == ColumnKind::kContact ? 1.F : kLargest;
  const float low = column.kind == ColumnKind::kContact ? 0.F : -kLargest;
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] <= bound && values[i] >= low) {
      continue;
    }
    return Error(
        source, Where(manifest, static_cast<int64_t>(i) / width, column.name),
        column.kind == ColumnKind::kContact ? "a number from 0 to 1"
                                            : "a finite number of at most 1e6",
        absl::StrCat(values[i]));
  }
  if (column.kind != ColumnKind::kRotation) return absl::OkStatus();
  return CheckUnit(column, manifest, values, source);
}

absl::Status ParseJson(absl::string_view json, bool ignore_unknown,
                       absl::string_view source, v1::MotionLibrary* manifest) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = ignore_unknown;
  manifest->Clear();
  const auto status = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), manifest,
      options);
  if (status.ok()) return absl::OkStatus();
  return Error(source, "manifest", "a motion library",
               std::string(status.message()));
}

}  // namespace

absl::StatusOr<v1::MotionLibrary> ParseManifest(absl::string_view json,
                                                absl::string_view source) {
  v1::MotionLibrary manifest;
  absl::Status status =
      ParseJson(json, /*ignore_unknown=*/false, source, &manifest);
  if (!status.ok()) {
    // A newer writer's unknown fields must not hide its version.
    SINEW_RETURN_IF_ERROR(
        ParseJson(json, /*ignore_unknown=*/true, source, &manifest));
  }
  if (manifest.format_version() != kLibraryFormatVersion) {
    return Error(source, "format_version", absl::StrCat(kLibraryFormatVersion),
                 absl::StrCat(manifest.format_version(),
                              manifest.format_version() > kLibraryFormatVersion
                                  ? " (written by a newer version)"
                                  : ""));
  }
  if (!status.ok()) return status;
  return manifest;
}

absl::Status CheckManifest(const v1::MotionLibrary& manifest,
                           absl::string_view source) {
  const double rate = manifest.frames_per_second();
  if (!(rate > 0 && std::isfinite(rate))) {
    return Error(source, "frames_per_second", "> 0", absl::StrCat(rate));
  }
  SINEW_RETURN_IF_ERROR(CheckNames(manifest.joints(), "joints", source));
  SINEW_RETURN_IF_ERROR(CheckNames(manifest.bodies(), "bodies", source));
  SINEW_RETURN_IF_ERROR(CheckNames(manifest.feet(), "feet", source));
  if (manifest.joints().empty()) return Error(source, "joints", "some", "none");
  if (manifest.bodies().empty()) return Error(source, "bodies", "some", "none");
  if (manifest.clips().empty()) return Error(source, "clips", "some", "none");
  std::vector<std::string> names;
  int64_t next = 0;
  for (const v1::ClipInfo& clip : manifest.clips()) {
    names.push_back(clip.name());
    SINEW_RETURN_IF_ERROR(
        CheckClip(clip, next, manifest.num_frames() - next, source));
    next += clip.num_frames();
  }
  SINEW_RETURN_IF_ERROR(CheckNames(names, "clips", source));
  if (next != manifest.num_frames()) {
    return Error(source, "num_frames",
                 absl::StrCat(next, " (the sum over clips)"),
                 absl::StrCat(manifest.num_frames()));
  }
  if (!IsSha256Hex(manifest.frames_sha256())) {
    return Error(source, "frames_sha256", "64 hex digits",
                 absl::StrCat("\"", manifest.frames_sha256(), "\""));
  }
  return absl::OkStatus();
}

absl::Status CheckFrameShapes(const v1::MotionLibrary& manifest,
                              const FrameTensors& frames,
                              absl::string_view source) {
  for (const FrameColumn& column : FrameColumns()) {
    SINEW_RETURN_IF_ERROR(CheckShape(column, manifest, frames, source));
  }
  for (const auto& [name, tensor] : frames) {
    const auto columns = FrameColumns();
    const bool known = std::any_of(
        columns.begin(), columns.end(),
        [&](const FrameColumn& column) { return name == column.name; });
    if (!known) {
      return Error(source, absl::StrCat("tensor ", name), "no such tensor",
                   "it");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckFrameValues(const v1::MotionLibrary& manifest,
                              const FrameTensors& frames,
                              absl::string_view source) {
  for (const FrameColumn& column : FrameColumns()) {
    SINEW_RETURN_IF_ERROR(CheckValues(
        column, manifest, frames.at(column.name).float32(), source));
  }
  return absl::OkStatus();
}

}  // namespace sinew::motion
