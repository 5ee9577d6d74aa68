#include "tools/evaluation/rejected_clips.h"

#include <nlohmann/json.hpp>

#include "common/files.h"

namespace sinew::evaluation {

std::optional<int> RejectedClips(const std::string& library, int clips) {
  using Json = nlohmann::json;
  const auto text = ReadFile(JoinPath(library, "report.json"));
  if (!text.ok()) return std::nullopt;
  const Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.contains("clips")) return std::nullopt;
  int kept = 0, rejected = 0;
  for (const Json& clip : report["clips"]) {
    if (!clip.is_object()) return std::nullopt;
    const Json status = clip.value("status", Json());
    if (status != "rejected") {
      ++kept;
    } else if (clip.contains("frames")) {
      ++rejected;
    }
  }
  if (kept != clips) return std::nullopt;
  return rejected;
}

}  // namespace sinew::evaluation
