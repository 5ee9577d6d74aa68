#include "tools/evaluation/evaluation_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "sim/motion/library.h"
#include "sim/world/randomisation.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {
namespace {

using Json = nlohmann::ordered_json;

// Tenths of a millimetre are enough for a picture.
double Rounded(double mm) { return std::round(mm * 10) / 10; }

void AddErrors(const MetricMeans& means, int64_t frames,
               const std::vector<double>& body_mm, Json* to) {
  const auto mean = [](double value, int64_t over) {
    return over > 0 ? Json(value) : Json(nullptr);
  };
  (*to)["e_g_mpjpe_mm"] = mean(means.e_g_mpjpe_mm, frames);
  (*to)["e_mpjpe_mm"] = mean(means.e_mpjpe_mm, frames);
  (*to)["e_acc"] = mean(means.e_acc, means.acceleration_frames);
  (*to)["e_vel"] = mean(means.e_vel, means.velocity_frames);
  (*to)["body_mm"] = body_mm;
}

Json SetObject(const SetSummary& set) {
  Json object = {{"clips", set.clips},
                 {"succeeded_clips", set.succeeded_clips},
                 {"success_rate", set.success_rate},
                 {"first_start_successes", set.first_start_successes},
                 {"starts", set.starts},
                 {"succeeded_starts", set.succeeded_starts},
                 {"survived_share", set.survived_share},
                 {"frames", set.frames}};
  AddErrors(set.means, set.frames, set.body_mm, &object);
  return object;
}

// The papers' table: a set, the same of its clips that succeeded, which errors
// are published of, and the zero action.
Json SplitObject(const SetSummary& set, const SetSummary& successful,
                 const SetSummary& zero_action) {
  Json object = SetObject(set);
  object["successful"] = SetObject(successful);
  object["zero_action"] = SetObject(zero_action);
  return object;
}

// Where some clips are left out.
void AddSplits(const Evaluation& evaluation, Json* file) {
  const EvaluationSummary& policy = evaluation.policy;
  const EvaluationSummary& zero = evaluation.zero_action;
  if (policy.left_out.clips == 0) return;
  (*file)["training"] =
      SplitObject(policy.training, policy.training_successful, zero.training);
  (*file)["left_out"] =
      SplitObject(policy.left_out, policy.left_out_successful, zero.left_out);
}

Json ImportedObject(const SetSummary& overall, int rejected) {
  const int clips = overall.clips + rejected;
  return {
      {"clips", clips},
      {"rejected_clips", rejected},
      {"succeeded_clips", overall.succeeded_clips},
      {"success_rate",
       clips > 0 ? static_cast<double>(overall.succeeded_clips) / clips : 0.0}};
}

Json ClipObject(const ClipSummary& clip) {
  Json object = {{"success", clip.success},
                 {"first_start_success", clip.first_start_success},
                 {"starts", clip.starts},
                 {"succeeded_starts", clip.succeeded_starts},
                 {"frames", clip.frames},
                 {"failed_at_frame", clip.failed_at_frame}};
  AddErrors(clip.means, clip.frames, clip.body_mm, &object);
  return object;
}

Json ProfileObject(const ErrorProfile& profile, size_t bodies, double seconds) {
  Json rows = Json::array();
  for (size_t body = 0; body < bodies; ++body) {
    Json row = Json::array();
    for (int bin = 0; bin < profile.bins(); ++bin) {
      // A bin that nobody reached has no error, not a small one.
      row.push_back(
          profile.visits(bin) == 0
              ? Json(nullptr)
              : Json(Rounded(profile.mean_mm(static_cast<int>(body), bin))));
    }
    rows.push_back(std::move(row));
  }
  return {{"seconds", seconds}, {"body_mm", std::move(rows)}};
}

// What a clip was to the training of a bundle that says so of its own.
std::string UseOf(const std::string& clip, const bundle::ClipUses& uses) {
  const auto use = uses.find(clip);
  return use == uses.end() ? "not in training"
                           : std::string(bundle::WordsOf(use->second));
}

Json Clips(const Subject& subject, const bundle::ClipUses& uses,
           const Evaluation& evaluation) {
  const v1::MotionLibrary& library = subject.library().manifest();
  Json clips = Json::array();
  for (size_t i = 0; i < evaluation.policy.clips.size(); ++i) {
    const ClipSummary& summary = evaluation.policy.clips[i];
    const v1::ClipInfo& info = library.clips(summary.clip);
    Json clip = {{"name", info.name()}};
    clip.update(ClipObject(summary));
    clip["loops"] = info.loops();
    if (info.left_out()) clip["left_out"] = true;
    if (!uses.empty()) clip["use"] = UseOf(info.name(), uses);
    clip["zero_action"] = ClipObject(evaluation.zero_action.clips[i]);
    if (i < evaluation.profiles.size()) {
      clip["profile"] = ProfileObject(
          evaluation.profiles[i], subject.character().tracked().size(),
          static_cast<double>(info.num_frames()) / library.frames_per_second());
    }
    clips.push_back(std::move(clip));
  }
  return clips;
}

void AddRecovered(const FallenFigures& figures, Json* to) {
  (*to)["recovered_3_s"] = figures.recovered_3_s;
  (*to)["recovered_5_s"] = figures.recovered_5_s;
}

Json SecondsOrNull(const std::optional<double>& seconds) {
  return seconds ? Json(*seconds) : Json(nullptr);
}

// The policy's shares and starts, and the zero action's shares below them.
void AddBoth(const motion::Library& library, const FallenFigures& policy,
             const FallenFigures& zero_action, Json* to) {
  AddRecovered(policy, to);
  Json rows = Json::array();
  for (const FallenRow& row : policy.rows) {
    rows.push_back({{"state", row.state},
                    {"clip", library.clip(row.clip).name()},
                    {"recovered_s", SecondsOrNull(row.recovered_s)},
                    {"carried_s", SecondsOrNull(row.carried_s)},
                    {"seconds", row.seconds}});
  }
  (*to)["rows"] = std::move(rows);
  Json zero = Json::object();
  AddRecovered(zero_action, &zero);
  (*to)["zero_action"] = std::move(zero);
}

Json FallenObject(const motion::Library& library,
                  const FallenEvaluation& fallen) {
  Json object = {{"starts", fallen.starts},
                 {"seed", fallen.seed},
                 {"clips", fallen.clips},
                 {"seconds", fallen.seconds},
                 {"reference_stands_seconds", fallen.reference_stands_seconds}};
  AddBoth(library, fallen.policy, fallen.zero_action, &object);
  if (fallen.get_up) {
    const FallenEvaluation::GetUp& get_up = *fallen.get_up;
    Json part = {{"reference_stands_seconds", get_up.reference_stands_seconds}};
    AddBoth(library, get_up.policy, get_up.zero_action, &part);
    object["get_up"] = std::move(part);
  }
  return object;
}

Json Definitions(const Subject& subject) {
  const double fall =
      subject.assets->recipe().evaluation().max_mean_body_distance();
  return {
      {"success", "a clip succeeds if all its starts survive"},
      {"first_start_success", "its start on the first frame survives"},
      {"survived",
       "the mean distance of tracked bodies from the reference "
       "never exceeds fall_distance_m"},
      {"fall_distance_m", fall},
      {"survived_share", "frames reached / frames asked for"},
      {"e_g_mpjpe_mm",
       "mean distance of tracked bodies from the reference, mm"},
      {"e_mpjpe_mm", "the same with the root's position subtracted, mm"},
      {"e_vel", "mean change of that offset per frame, mm/frame at 30 Hz"},
      {"e_acc", "its second difference, mm/frame^2 at 30 Hz"},
      {"body_mm", "e_g_mpjpe of each body, in the order of bodies, mm"},
      {"failed_at_frame", "earliest failure, counted from its start; -1: none"},
      {"frames", "compared, over all starts; errors are means over them"},
      {"use", "what a clip was to the training of the bundle, as it says"},
      {"zero_action",
       "the same task with action 0: targets are where the bundle's action law "
       "places them by itself (action.placement of its manifest): at the "
       "reference, the current pose or the default pose"},
      {"successful",
       "of the clips that succeed: what papers publish errors of"},
      {"imported",
       "every clip that was imported; those that the import turned away count "
       "as failed"},
      {"profile", "body_mm over the clip: evenly spaced bins of its frames"},
      {"fallen",
       "starts on the floor, of a seed that no recipe trains on: recovered are "
       "the shares that within so many seconds are nearer than fall_distance_m "
       "with the head at 0.8 of the reference's height or above, while the "
       "reference's root is at 0.8 of the standing height or above, and stay "
       "so to the end; get_up: the same with the library's nearest get-up for "
       "a reference, instead of a clip that is up already, and from its end on "
       "the nearest frame of a clip that stays up; rows: each start, with the "
       "index that sinew render --fallen-state takes; since when it stood and "
       "tracked to the end, and when it went on after a get-up, or null"}};
}

}  // namespace

std::string EvaluationJson(const Subject& subject,
                           const EvaluationOptions& options,
                           const EvaluationSource& source,
                           const Evaluation& evaluation) {
  const motion::Library& library = subject.library();
  Json file = {{"format_version", 1},
               {"overall", SetObject(evaluation.policy.overall)},
               {"successful", SetObject(evaluation.policy.successful)},
               {"zero_action", SetObject(evaluation.zero_action.overall)},
               {"clips", Clips(subject, source.clip_uses, evaluation)},
               {"seconds", options.seconds},
               {"starts_per_clip", options.starts},
               {"frames_per_second", library.manifest().frames_per_second()},
               {"bodies", TrackedBodyNames(subject)},
               {"bundle",
                {{"path", source.bundle},
                 {"manifest_sha256", source.manifest_sha256},
                 {"snapshot_sha256", subject.policy->sha256()}}},
               {"library",
                {{"path", source.motions},
                 {"sha256", library.digest()},
                 {"character", library.manifest().character()}}},
               {"definitions", Definitions(subject)}};
  AddSplits(evaluation, &file);
  if (source.rejected_clips) {
    file["imported"] =
        ImportedObject(evaluation.policy.overall, *source.rejected_clips);
  }
  if (evaluation.fallen) {
    file["fallen"] = FallenObject(subject.library(), *evaluation.fallen);
  }
  const world::Randomisation& random = subject.assets->task().randomisation();
  if (random.on() && random.in_evaluation()) {
    file["randomised"] = {{"seed", kEvaluationSeed}};
  }
  return file.dump(2, ' ', /*ensure_ascii=*/false,
                   Json::error_handler_t::replace) +
         "\n";
}

}  // namespace sinew::evaluation
