#include "sim/motion/library.h"

#include <limits>
#include <utility>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "google/protobuf/util/json_util.h"
#include "sim/motion/frame_columns.h"
#include "sim/motion/library_check.h"

namespace sinew::motion {
namespace {

constexpr char kManifestFile[] = "manifest.json";
constexpr char kFramesFile[] = "frames.safetensors";
constexpr int64_t kMaxManifestBytes = int64_t{1} << 30;

absl::Status CheckDigest(const v1::MotionLibrary& manifest,
                         absl::string_view frames, absl::string_view source) {
  const std::string found = Sha256Hex(frames);
  if (found == manifest.frames_sha256()) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      source, ": ", kFramesFile, ": expected SHA-256 ",
      manifest.frames_sha256(), ", found ", found, " (", frames.size(),
      " bytes): truncated, altered, or of another library"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Library>> Library::Load(
    const std::string& directory) {
  SINEW_ASSIGN_OR_RETURN(
      const std::string manifest,
      ReadFile(JoinPath(directory, kManifestFile), kMaxManifestBytes));
  SINEW_ASSIGN_OR_RETURN(const std::string frames,
                         ReadFile(JoinPath(directory, kFramesFile)));
  return FromBytes(manifest, frames, directory);
}

absl::StatusOr<std::unique_ptr<Library>> Library::FromBytes(
    absl::string_view manifest_json, absl::string_view frames,
    absl::string_view source) {
  auto library = absl::WrapUnique(new Library());
  SINEW_ASSIGN_OR_RETURN(library->manifest_,
                         ParseManifest(manifest_json, source));
  SINEW_RETURN_IF_ERROR(CheckManifest(library->manifest_, source));
  SINEW_RETURN_IF_ERROR(CheckDigest(library->manifest_, frames, source));
  SINEW_ASSIGN_OR_RETURN(
      library->frames_,
      ParseSafetensors(frames, absl::StrCat(source, ": ", kFramesFile)));
  SINEW_RETURN_IF_ERROR(
      CheckFrames(library->manifest_, library->frames_, source));
  for (const FrameColumn& column : FrameColumns()) {
    library->base_.*column.pointer =
        library->frames_.at(column.name).float32().data();
    library->row_widths_.push_back(RowWidth(column, library->manifest_));
  }
  library->digest_ = Sha256Hex(
      absl::StrCat(manifest_json, library->manifest_.frames_sha256()));
  return library;
}

absl::Status Library::Save(const v1::MotionLibrary& manifest,
                           const TensorMap& frames,
                           const std::string& directory) {
  v1::MotionLibrary complete = manifest;
  const std::string frames_bytes = SerializeSafetensors(frames);
  complete.set_format_version(kLibraryFormatVersion);
  complete.set_frames_sha256(Sha256Hex(frames_bytes));
  SINEW_RETURN_IF_ERROR(CheckManifest(complete, directory));
  SINEW_RETURN_IF_ERROR(CheckFrames(complete, frames, directory));

  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto status =
      google::protobuf::util::MessageToJsonString(complete, &json, options);
  if (!status.ok()) {
    return absl::InternalError(absl::StrCat(
        directory, ": manifest: ", std::string(status.message())));
  }
  SINEW_RETURN_IF_ERROR(MakeDirectories(directory));
  SINEW_RETURN_IF_ERROR(
      WriteFileAtomically(JoinPath(directory, kFramesFile), frames_bytes));
  return WriteFileAtomically(JoinPath(directory, kManifestFile), json);
}

int Library::FindClip(absl::string_view name) const {
  for (int i = 0; i < num_clips(); ++i) {
    if (clip(i).name() == name) return i;
  }
  return -1;
}

FrameView Library::frame(int clip, int64_t frame) const {
  const v1::ClipInfo& info = manifest_.clips(clip);
  SINEW_DCHECK(frame >= 0 && frame < info.num_frames())
      << "frame " << frame << " of clip " << info.name();
  const int64_t row = info.first_frame() + frame;
  FrameView view;
  const int64_t* width = row_widths_.data();
  for (const FrameColumn& column : FrameColumns()) {
    view.*column.pointer = base_.*column.pointer + row * *width++;
  }
  return view;
}

int64_t LastFrame(const v1::ClipInfo& clip) {
  // Far beyond any episode, yet safe to add to.
  constexpr int64_t kForEver = std::numeric_limits<int64_t>::max() / 4;
  return clip.loops() ? kForEver : clip.num_frames() - 1;
}

}  // namespace sinew::motion
