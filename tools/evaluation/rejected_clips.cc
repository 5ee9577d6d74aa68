#include "tools/evaluation/rejected_clips.h"

#include <nlohmann/json.hpp>

#include "common/files.h"

namespace sinew::evaluation {

using Json = nlohmann::json;

namespace {

// Empty unless there is text.
std::string TextOf(const Json& object, const char* field) {
  const Json value = object.value(field, Json());
  return value.is_string() ? value.get<std::string>() : "";
}

}  // namespace

std::optional<std::vector<RejectedClip>> RejectedClips(
    const std::string& library, int clips) {
  const auto text = ReadFile(JoinPath(library, "report.json"));
  if (!text.ok()) return std::nullopt;
  const Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.contains("clips")) return std::nullopt;
  int kept = 0;
  std::vector<RejectedClip> rejected;
  for (const Json& clip : report["clips"]) {
    if (!clip.is_object()) return std::nullopt;
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
