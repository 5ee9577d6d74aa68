#include "sim/import/read_clip.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/detect_format.h"
#include "sim/import/formats/deepmimic.h"

namespace sinew::import {
namespace {

absl::StatusOr<ClipFormat> FormatOf(const std::string& path,
                                    absl::string_view bytes,
                                    const ReadClipOptions& options) {
  if (!options.format.empty()) return FormatOfName(options.format);
  return DetectFormat(path, bytes);
}

}  // namespace

absl::StatusOr<std::vector<std::string>> CompanionFiles(
    const std::string& path, absl::string_view bytes,
    const ReadClipOptions& options) {
  SINEW_RETURN_IF_ERROR(FormatOf(path, bytes, options).status());
  return std::vector<std::string>();
}

absl::StatusOr<Source> ReadClip(const std::string& path,
                                absl::string_view bytes,
                                absl::string_view name,
                                const ImportModel* /*model*/,
                                const ReadClipOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const ClipFormat format,
                         FormatOf(path, bytes, options));
  if (format == ClipFormat::kDeepMimic) {
    return ParseDeepMimic(bytes, name, path);
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": cannot be read: ", FormatName(format)));
}

}  // namespace sinew::import
