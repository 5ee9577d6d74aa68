#include "tools/evaluation/rejected_clips.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::evaluation {

using Json = nlohmann::json;

namespace {

// Empty unless there is text.
std::string TextOf(const Json& object, const char* field) {
  const Json value = object.value(field, Json());
  return value.is_string() ? value.get<std::string>() : "";
}

absl::Status Damaged(const std::string& path) {
  return absl::InvalidArgumentError(
      absl::StrCat(path,
                   ": expected the report of an import, an object with a "
                   "list of clips, found something else; import again"));
}

}  // namespace

absl::StatusOr<std::optional<std::vector<RejectedClip>>> RejectedClips(
    const std::string& library, int clips) {
  const std::string path = JoinPath(library, "report.json");
  const auto text = ReadFile(path);
  if (absl::IsNotFound(text.status())) return std::nullopt;
  SINEW_RETURN_IF_ERROR(text.status());
  const Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  const Json list = report.is_object() ? report.value("clips", Json()) : Json();
  if (!list.is_array()) return Damaged(path);
  int kept = 0;
  std::vector<RejectedClip> rejected;
  for (const Json& clip : list) {
    if (!clip.is_object()) return Damaged(path);
    const Json status = clip.value("status", Json());
    if (status != "rejected") {
      ++kept;
    } else if (clip.contains("frames")) {
      rejected.push_back({TextOf(clip, "name"), TextOf(clip, "reason")});
    }
  }
  if (kept != clips) return std::nullopt;
  return rejected;
}

}  // namespace sinew::evaluation
