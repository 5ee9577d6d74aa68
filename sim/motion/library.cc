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
// Writers take seconds between two manifests.
constexpr int kMostAttempts = 3;

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
  const std::string path = JoinPath(directory, kManifestFile);
  SINEW_ASSIGN_OR_RETURN(std::string manifest,
                         ReadFile(path, kMaxManifestBytes));
  // If the manifest changes meanwhile, the frames may be those of the next one.
  for (int attempt = 1;; ++attempt) {
    absl::StatusOr<std::unique_ptr<Library>> library =
        OpenOnce(manifest, directory);
    SINEW_ASSIGN_OR_RETURN(std::string now, ReadFile(path, kMaxManifestBytes));
    if (now == manifest) return library;
    if (attempt == kMostAttempts) {
      return absl::UnavailableError(absl::StrCat(
          directory, ": expected a library at rest, found another ",
          kManifestFile, " at each of ", attempt, " attempts to open it"));
    }
    manifest = std::move(now);
  }
}

absl::StatusOr<std::unique_ptr<Library>> Library::OpenOnce(
    const std::string& manifest_json, const std::string& directory) {
  auto library = absl::WrapUnique(new Library());
  SINEW_RETURN_IF_ERROR(library->ReadManifest(manifest_json, directory));
  SINEW_ASSIGN_OR_RETURN(library->mapped_,
                         MappedFile::Open(JoinPath(directory, kFramesFile)));
  const absl::Status status = library->Attach(library->mapped_->bytes());
  if (status.ok()) return library;
  return absl::DataLossError(
      absl::StrCat(status.message(), " (", library->mapped_->bytes().size(),
                   " bytes): truncated, altered, of another library, or one "
                   "that is being written"));
}

absl::StatusOr<std::unique_ptr<Library>> Library::FromBytes(
    absl::string_view manifest_json, absl::string_view frames,
    absl::string_view source) {
  auto library = absl::WrapUnique(new Library());
  SINEW_RETURN_IF_ERROR(library->ReadManifest(manifest_json, source));
  SINEW_RETURN_IF_ERROR(CheckDigest(library->manifest_, frames, source));
  library->copy_ = std::string(frames);
  SINEW_RETURN_IF_ERROR(library->Attach(library->copy_));
  SINEW_RETURN_IF_ERROR(
      CheckFrameValues(library->manifest_, library->frames_, source));
  return library;
}

absl::StatusOr<std::unique_ptr<Library>> Library::FromMapped(
    absl::string_view manifest_json, std::shared_ptr<const MappedFile> frames,
    absl::string_view source) {
  auto library = absl::WrapUnique(new Library());
  SINEW_RETURN_IF_ERROR(library->ReadManifest(manifest_json, source));
  library->mapped_ = std::move(frames);
  // Its digest before anything is read as what it should be.
  SINEW_RETURN_IF_ERROR(
      CheckDigest(library->manifest_, library->mapped_->bytes(), source));
  SINEW_RETURN_IF_ERROR(library->Attach(library->mapped_->bytes()));
  SINEW_RETURN_IF_ERROR(
      CheckFrameValues(library->manifest_, library->frames_, source));
  return library;
}

absl::Status Library::ReadManifest(absl::string_view json,
                                   absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(manifest_, ParseManifest(json, source));
  SINEW_RETURN_IF_ERROR(CheckManifest(manifest_, source));
  source_ = std::string(source);
  digest_ = Sha256Hex(absl::StrCat(json, manifest_.frames_sha256()));
  return absl::OkStatus();
}

absl::Status Library::Attach(absl::string_view frames) {
  SINEW_ASSIGN_OR_RETURN(
      SafetensorsView view,
      ViewSafetensors(frames, absl::StrCat(source_, ": ", kFramesFile)));
  SINEW_RETURN_IF_ERROR(CheckFrameShapes(manifest_, view.tensors, source_));
  bytes_ = frames;
  frames_ = std::move(view.tensors);
  for (const FrameColumn& column : FrameColumns()) {
    base_.*column.pointer = frames_.at(column.name).float32().data();
    row_widths_.push_back(RowWidth(column, manifest_));
  }
  return absl::OkStatus();
}

absl::Status Library::Verify() const {
  SINEW_RETURN_IF_ERROR(CheckDigest(manifest_, bytes_, source_));
  return CheckFrameValues(manifest_, frames_, source_);
}

absl::Status Library::Save(const v1::MotionLibrary& manifest,
                           const TensorMap& frames,
                           const std::string& directory) {
  v1::MotionLibrary complete = manifest;
  const std::string frames_bytes = SerializeSafetensors(frames);
  complete.set_format_version(kLibraryFormatVersion);
  complete.set_frames_sha256(Sha256Hex(frames_bytes));
  SINEW_RETURN_IF_ERROR(CheckManifest(complete, directory));
  const FrameTensors views = ViewTensors(frames);
  SINEW_RETURN_IF_ERROR(CheckFrameShapes(complete, views, directory));
  SINEW_RETURN_IF_ERROR(CheckFrameValues(complete, views, directory));

  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto status =
      google::protobuf::util::MessageToJsonString(complete, &json, options);
  if (!status.ok()) {
    return absl::InternalError(
        absl::StrCat(directory, ": manifest: ", std::string(status.message())));
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
