#include "tools/evaluation/same_task.h"

#include <algorithm>

#include "common/json_fields.h"

namespace sinew::evaluation {

absl::Status CheckSameTask(const nlohmann::json& first,
                           const nlohmann::json& found,
                           const std::string& file) {
  using Pointer = nlohmann::json::json_pointer;
  const nlohmann::json none;
  for (const char* field : {"library.sha256", "starts_per_clip", "seconds",
                            "randomised", "definitions.fall_distance_m"}) {
    std::string path = std::string("/") + field;
    std::ranges::replace(path, '.', '/');
    const Pointer at(path);
    const nlohmann::json& expected = first.contains(at) ? first[at] : none;
    const nlohmann::json& other = found.contains(at) ? found[at] : none;
    if (expected == other) continue;
    return UnfitField(file, field, expected.dump(), other.dump());
  }
  return absl::OkStatus();
}

}  // namespace sinew::evaluation
