#ifndef SINEW_SIM_IMPORT_READ_CLIP_H_
#define SINEW_SIM_IMPORT_READ_CLIP_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

struct ReadClipOptions {
  // Name of the format (detect_format.h); empty: detected.
  std::string format;
  // Skeleton of AMC files; empty: the one that belongs to each (same folder,
  // same name or the subject's).
  std::string asf;
  // Units, axes, rate, order of quaternions: what the files do not say, or say
  // wrongly.
  ReadOptions read;
};

// Largest file of any format, bytes.
inline constexpr int64_t kMaxClipBytes = int64_t{1} << 30;

// Files besides the clip's own that its content depends on: the skeleton of an
// AMC file. INVALID_ARGUMENT naming file and candidates if it needs one and
// there is none.
absl::StatusOr<std::vector<std::string>> CompanionFiles(
    const std::string& path, absl::string_view bytes,
    const ReadClipOptions& options);

// A clip of any format. `bytes` is the file's content, `name` becomes the
// clip's; `model` is the character, whose joints a robot's recordings are held
// against (null: none, and robots' recordings are refused). Blocks on reading
// companions.
//
// Total: any bytes give a clip or an error naming the file (INVALID_ARGUMENT,
// RESOURCE_EXHAUSTED, NOT_FOUND for companions).
absl::StatusOr<Source> ReadClip(const std::string& path,
                                absl::string_view bytes, absl::string_view name,
                                const ImportModel* model,
                                const ReadClipOptions& options);

// The files that a user means: folders are walked (sorted, without following
// links), of which only files that look like clips are taken; files are taken
// as they are, also when they are none or not there. NOT_FOUND for a folder
// without clips.
absl::StatusOr<std::vector<std::string>> ExpandFolders(
    const std::vector<std::string>& paths);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_READ_CLIP_H_
