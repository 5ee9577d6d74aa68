#include "tools/motion_report/motion_report.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "nlohmann/json.hpp"
#include "sim/import/clip_cache.h"
#include "tools/motion_report/body_shapes.h"
#include "tools/motion_report/page.h"
#include "tools/motion_report/strips.h"
#include "tools/motion_report/trajectory.h"

namespace sinew::motion_report {
namespace {

using Json = nlohmann::json;

constexpr int64_t kMaxReportBytes = int64_t{1} << 30;

absl::StatusOr<Json> ReadReport(const std::string& library) {
  const std::string path = JoinPath(library, "report.json");
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(path, kMaxReportBytes));
  Json report = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.value("clips", Json()).is_array() ||
      !report.value("frames_per_second", Json()).is_number() ||
      !report.value("character", Json()).is_string()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": expected the report of an import"));
  }
  for (const Json& clip : report["clips"]) {
    if (!clip.is_object() || !clip.value("name", Json()).is_string() ||
        !clip.value("status", Json()).is_string()) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": expected clips with name and status"));
    }
  }
  return report;
}

// Clips to show, the gravest first, else in the report's order.
absl::StatusOr<std::vector<size_t>> Order(const Json& clips,
                                          const MotionReportOptions& options) {
  std::set<std::string> wanted(options.clips.begin(), options.clips.end());
  std::vector<size_t> order;
  for (const char* status : {"rejected", "warned", "ok"}) {
    for (size_t i = 0; i < clips.size(); ++i) {
      const std::string name = clips[i]["name"];
      if (clips[i]["status"] != status) continue;
      if (!options.clips.empty() &&
          std::find(options.clips.begin(), options.clips.end(), name) ==
              options.clips.end()) {
        continue;
      }
      wanted.erase(name);
      order.push_back(i);
    }
  }
  if (wanted.empty()) return order;
  return absl::NotFoundError(
      absl::StrCat("clip \"", *wanted.begin(), "\": not in the report"));
}

// What besides report.json is shown of the clips.
class Showing {
 public:
  Showing(const character::Character& character,
          const MotionReportOptions& options, const StopToken& stop,
          double rate, import::ClipCache cache)
      : character_(character),
        options_(options),
        stop_(stop),
        rate_(rate),
        cache_(std::move(cache)) {}

  absl::Status Add(const std::vector<size_t>& order, Json* clips) {
    const int total =
        std::min(options_.pictures, static_cast<int>(order.size()));
    for (const size_t i : order) {
      if (stop_.stop_requested()) {
        return absl::CancelledError("report: stopped before its end");
      }
      if (full_ && (drawn_ >= options_.pictures || !note_.empty())) break;
      Json& clip = (*clips)[i];
      const Json cache_key = clip.value("cache_key", Json());
      if (!cache_key.is_string()) continue;
      const std::string key = cache_key.get<std::string>();
      if (key.empty()) continue;
      const auto loaded = cache_.Load(key);
      if (!loaded.ok()) {
        clip["note"] = std::string(loaded.status().message());
        continue;
      }
      if (AddStrip(loaded->frames, &clip) && options_.on_picture) {
        options_.on_picture(drawn_, total);
      }
      AddTrajectory(*loaded, &clip);
    }
    return absl::OkStatus();
  }

  std::vector<Trajectory> TakeTrajectories() { return std::move(shown_); }
  const std::string& note() const { return note_; }

 private:
  // True if it has drawn one.
  bool AddStrip(const TensorMap& frames, Json* clip) {
    if (drawn_ >= options_.pictures || !note_.empty()) return false;
    if (drawer_ == nullptr) {
      auto drawer = StripDrawer::Create(character_);
      if (!drawer.ok()) {
        note_ = std::string(drawer.status().message());
        return false;
      }
      drawer_ = *std::move(drawer);
    }
    const auto strip = drawer_->Draw(frames, rate_);
    if (!strip.ok()) {
      (*clip)["note"] = std::string(strip.status().message());
      return false;
    }
    (*clip)["strip"] = *strip;
    ++drawn_;
    return true;
  }

  void AddTrajectory(const import::CachedClip& loaded, Json* clip) {
    if (full_) return;
    auto trajectory = MakeTrajectory(loaded.frames, rate_, loaded.preview);
    if (!trajectory.ok()) {
      (*clip)["note"] = std::string(trajectory.status().message());
      return;
    }
    bytes_ += trajectory->bytes();
    if (static_cast<double>(bytes_) > 1e6 * options_.trajectory_megabytes) {
      full_ = true;
      return;
    }
    (*clip)["trajectory"] = shown_.size();
    shown_.push_back(*std::move(trajectory));
  }

  const character::Character& character_;
  const MotionReportOptions& options_;
  const StopToken stop_;
  const double rate_;
  const import::ClipCache cache_;
  std::unique_ptr<StripDrawer> drawer_;
  std::string note_;  // why there are no pictures
  int drawn_ = 0;
  size_t bytes_ = 0;
  bool full_ = false;
  std::vector<Trajectory> shown_;
};

}  // namespace

absl::StatusOr<std::string> WriteMotionReport(
    const character::Character& character, const std::string& library,
    const MotionReportOptions& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(Json report, ReadReport(library));
  SINEW_ASSIGN_OR_RETURN(const std::vector<size_t> order,
                         Order(report["clips"], options));
  Showing showing(character, options, stop, report["frames_per_second"],
                  import::ClipCache(JoinPath(library, "cache")));
  SINEW_RETURN_IF_ERROR(showing.Add(order, &report["clips"]));
  report["library"] = library;
  report["build"] = BuildIdentity();
  report["note"] = showing.note();
  report["bodies"] = BodyShapes(*character.model());
  const std::string path = JoinPath(library, "report.html");
  SINEW_RETURN_IF_ERROR(
      WriteFileAtomically(path, MakePage(report, showing.TakeTrajectories())));
  return path;
}

absl::StatusOr<std::string> ReportedCharacter(const std::string& library) {
  SINEW_ASSIGN_OR_RETURN(const Json report, ReadReport(library));
  return report["character"].get<std::string>();
}

}  // namespace sinew::motion_report
