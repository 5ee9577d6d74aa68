#include "tools/curriculum/run_curriculum.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/curriculum/bin_sums.h"
#include "learner/curriculum/start_rule.h"
#include "learner/state/newest_state.h"
#include "proto/sinew/v1/training_state.pb.h"
#include "tools/curriculum/summary_json.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::ordered_json;

// The learner drops old states while this reads; the newest is there then.
constexpr int kAttempts = 3;

absl::StatusOr<v1::TrainingState> ReadLatest(
    const StateStore& states, const Clock& clock,
    std::vector<std::string>* warnings) {
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<checkpoint::ArtifactStore> store,
      checkpoint::OpenStore(states.where, checkpoint::StoreAccess::kRead,
                            states.security, clock, states.stop));
  absl::StatusOr<v1::TrainingState> state;
  for (int i = 0; i < kAttempts; ++i) {
    warnings->clear();
    state = learner::LoadLatestCounters(*store, warnings);
    // All were dropped since they were listed: that reads as damage.
    if (!absl::IsDataLoss(state.status())) break;
  }
  return state;
}

absl::StatusOr<v1::TrainingState> ReadState(
    const std::string& run, const StateStore& states, const Clock& clock,
    std::vector<std::string>* warnings) {
  auto state = ReadLatest(states, clock, warnings);
  if (absl::IsNotFound(state.status())) {
    return absl::NotFoundError(absl::StrCat(
        run, ": expected a training state in ", states.where,
        ", found none; the first is saved after checkpointing.interval "
        "iterations, or when training ends (",
        state.status().message(), ")"));
  }
  if (absl::IsDataLoss(state.status())) {
    return absl::DataLossError(
        absl::StrCat(run, ": ", states.where, ": ", state.status().message()));
  }
  return state;
}

std::string RuleName(v1::Start::Rule rule) {
  return absl::AsciiStrToLower(
      absl::StripPrefix(v1::Start::Rule_Name(rule), "RULE_"));
}

std::string ClipName(const v1::CurriculumTable& table, int clip) {
  return clip < table.clips_size() ? table.clips(clip).name()
                                   : absl::StrCat("clip ", clip);
}

// mm; null where no episode began.
Json TrackingError(double mean_body_distance_m, int64_t episodes) {
  return episodes > 0 ? Json(1e3 * mean_body_distance_m) : Json();
}

// By clip, the mean over its bins, each as often as episodes began there.
std::vector<Json> TrackingErrors(const v1::CurriculumTable& table,
                                 size_t clips) {
  std::vector<double> sums(clips);
  std::vector<int64_t> episodes(clips);
  for (const v1::CurriculumTable::Bin& bin : table.bins()) {
    sums[bin.clip()] +=
        static_cast<double>(bin.visits()) * bin.mean_body_distance();
    episodes[bin.clip()] += bin.visits();
  }
  std::vector<Json> errors;
  for (size_t c = 0; c < clips; ++c) {
    const auto count = static_cast<double>(std::max<int64_t>(1, episodes[c]));
    errors.push_back(TrackingError(sums[c] / count, episodes[c]));
  }
  return errors;
}

void AddEvaluations(const v1::CurriculumTable& table, int clip, Json& json) {
  const v1::CurriculumTable::Clip evaluated = clip < table.clips_size()
                                                  ? table.clips(clip)
                                                  : v1::CurriculumTable::Clip();
  const bool any = evaluated.evaluations() > 0;
  json["evaluations"] = evaluated.evaluations();
  json["failed_evaluations"] = evaluated.failed_evaluations();
  json["failed_latest"] = any ? Json(evaluated.failed_latest()) : Json();
  json["succeeded_share"] = any ? Json(evaluated.succeeded_share()) : Json();
  json["mean_error_mm"] = any ? Json(evaluated.mean_error_mm()) : Json();
}

Json ClipsJson(const v1::CurriculumTable& table, int hardest) {
  const auto statistics = learner::StatisticsByClip(table);
  const std::vector<Json> errors = TrackingErrors(table, statistics.size());
  Json clips = Json::array();
  for (const int c : learner::HardestClips(table, hardest)) {
    const learner::ClipStatistics& clip = statistics[c];
    Json json = {
        {"name", ClipName(table, c)},      {"visits", clip.visits},
        {"failures", clip.failures},       {"failure_rate", clip.failure_rate},
        {"probability", clip.probability}, {"tracking_error_mm", errors[c]},
        {"last_seen", clip.last_seen}};
    AddEvaluations(table, c, json);
    clips.push_back(std::move(json));
  }
  return clips;
}

Json BinsJson(const v1::CurriculumTable& table, double rate, int hardest) {
  Json bins = Json::array();
  for (const int b : learner::HardestBins(table, hardest)) {
    const v1::CurriculumTable::Bin& bin = table.bins(b);
    bins.push_back({{"clip", ClipName(table, bin.clip())},
                    {"from_s", bin.first_frame() / rate},
                    {"to_s", (bin.first_frame() + bin.num_frames()) / rate},
                    {"visits", bin.visits()},
                    {"failures", bin.failures()},
                    {"recent_passages", bin.recent_passages()},
                    {"recent_failures", bin.recent_failures()},
                    {"failure_rate", learner::RecentFailureRate(bin)},
                    {"probability", bin.probability()},
                    {"tracking_error_mm",
                     TrackingError(bin.mean_body_distance(), bin.visits())},
                    {"last_seen", bin.last_seen()}});
  }
  return bins;
}

Json LeftOutJson(const v1::CurriculumTable& table) {
  Json clips = Json::array();
  for (int c = 0; c < table.clips_size(); ++c) {
    if (!table.clips(c).left_out() || table.clips(c).evaluations() == 0) {
      continue;
    }
    Json json = {{"name", table.clips(c).name()}};
    AddEvaluations(table, c, json);
    clips.push_back(std::move(json));
  }
  return clips;
}

}  // namespace

absl::StatusOr<RunCurriculum> ReadRunCurriculum(const std::string& run,
                                                const Clock& clock,
                                                const StateStore& states) {
  const std::string config = JoinPath(run, "config.textproto");
  StateStore store = states;
  if (store.where.empty()) store.where = JoinPath(run, "checkpoints");
  const bool is_run = FileExists(config);
  if (!is_run || (states.where.empty() && !FileExists(store.where))) {
    return absl::NotFoundError(absl::StrCat(
        run, ": expected a run directory, found no ",
        is_run ? "checkpoints/ (of a learner with --checkpoint they are there)"
               : "config.textproto"));
  }
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(config));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe recipe, ParseRecipe(text, config));
  recipe = WithDefaults(std::move(recipe));
  RunCurriculum curriculum;
  SINEW_ASSIGN_OR_RETURN(v1::TrainingState state,
                         ReadState(run, store, clock, &curriculum.warnings));
  const std::string sha256 = Sha256Hex(PrintRecipe(recipe));
  if (!state.recipe_sha256().empty() && state.recipe_sha256() != sha256) {
    return absl::FailedPreconditionError(absl::StrCat(
        store.where, ": expected a state of the recipe in ", config,
        " (SHA-256 ", sha256, "), found one of another run's (",
        state.recipe_sha256(), ")"));
  }
  curriculum.run = run;
  curriculum.iteration = state.iteration();
  curriculum.samples = state.samples();
  curriculum.start = recipe.task().start();
  curriculum.frames_per_second = recipe.physics().control_hz();
  curriculum.table = std::move(*state.mutable_curriculum());
  curriculum.summary = learner::Summarise(
      curriculum.table, *learner::MakeStartRule(curriculum.start));
  return curriculum;
}

Json CurriculumJson(const RunCurriculum& curriculum, int hardest) {
  const v1::CurriculumTable drawn = learner::DrawnPart(
      curriculum.table, *learner::MakeStartRule(curriculum.start));
  return {{"run", curriculum.run},
          {"iteration", curriculum.iteration},
          {"samples", curriculum.samples},
          {"rule", RuleName(curriculum.start.rule())},
          {"bin_seconds", curriculum.start.bin_seconds()},
          {"summary", SummaryJson(curriculum.summary)},
          {"clips", ClipsJson(drawn, hardest)},
          {"bins", BinsJson(drawn, curriculum.frames_per_second, hardest)},
          {"left_out", LeftOutJson(curriculum.table)}};
}

}  // namespace sinew::tools
