// How long a body follows a clip with no policy at all: survival of the zero
// action by physics rate and action law. The first figure to look at for any
// change of actuation, gains or references.
//
//   bazel run -c opt //tools/bench:zero_action -- --library DIR
//       [--character humanoid] [--clip NAME] [--starts 32] [--seconds 10]

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/config/recipe.h"
#include "common/evaluation/evaluation_starts.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/tracking_task.h"

namespace sinew {
namespace {

struct Options {
  std::string character = "humanoid";
  std::string library;
  std::string clip;  // empty: the first
  int starts = 32;
  double seconds = 10;
};

// Frames until an episode would end in training, and in evaluation.
struct Survival {
  std::vector<int> training, evaluation;
};

// Frames survived from one start, at most start.steps().
void RunStart(const world::TrackingTask& task, const v1::EvaluationStart& start,
              mjData* data, Survival* survival) {
  const auto work = task.MakeWorkspace();
  const std::vector<float> zero(task.action_width(), 0.F);
  std::vector<double> target(zero.size()), previous(zero.size());
  world::Episode episode;
  episode.clip = start.clip();
  episode.start_frame = start.start_frame();
  task.Reset(episode, nullptr, data, absl::MakeSpan(previous), work.get());
  const double limit = task.recipe().evaluation().max_mean_body_distance();
  int training = start.steps();
  int frame = 0;
  while (frame < start.steps()) {
    task.Target(data, episode, zero, absl::MakeSpan(target), work.get());
    const world::StepResult result =
        task.Step(data, target, &episode, absl::MakeSpan(previous), work.get());
    if (result.terminated) training = std::min(training, frame);
    if (result.diverged || result.mean_body_distance > limit) break;
    ++frame;
  }
  survival->training.push_back(training);
  survival->evaluation.push_back(frame);
}

std::string Figures(std::vector<int> frames) {
  std::sort(frames.begin(), frames.end());
  double sum = 0;
  for (int count : frames) sum += count;
  char text[64];
  std::snprintf(text, sizeof text, "%6.1f %4d %4d %4d",
                sum / static_cast<double>(frames.size()), frames.front(),
                frames[frames.size() / 2], frames.back());
  return text;
}

absl::Status RunRow(const Options& options, const motion::Library& library,
                    double physics_hz, const v1::Action& law) {
  v1::Recipe recipe;
  recipe.mutable_physics()->set_physics_hz(physics_hz);
  recipe.mutable_physics()->set_control_hz(
      library.manifest().frames_per_second());
  *recipe.mutable_task()->mutable_action() = law;
  recipe = WithDefaults(recipe);
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(options.character, recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(const auto task, world::TrackingTask::Create(
                                              recipe, *character, library));
  SINEW_ASSIGN_OR_RETURN(const auto starts,
                         MakeEvaluationStarts(library.manifest(),
                                              options.starts, options.seconds));
  const int clip = options.clip.empty() ? 0 : library.FindClip(options.clip);
  if (clip < 0) {
    return absl::InvalidArgumentError("no clip \"" + options.clip + "\" in " +
                                      options.library);
  }
  const character::DataPtr data(mj_makeData(character->model()));
  Survival survival;
  for (const v1::EvaluationStart& start : starts) {
    if (start.clip() == clip) RunStart(*task, start, data.get(), &survival);
  }
  std::printf("%5.0f  %-5s %-8s %-7s | %s | %s\n", physics_hz,
              law.ramp() ? "ramp" : "hold",
              law.velocity_feedforward() ? "velocity" : "-",
              law.torque_feedforward() ? "torque" : "-",
              Figures(survival.training).c_str(),
              Figures(survival.evaluation).c_str());
  std::fflush(stdout);
  return absl::OkStatus();
}

absl::Status RunTable(const Options& options) {
  SINEW_ASSIGN_OR_RETURN(const auto library,
                         motion::Library::Load(options.library));
  SINEW_RETURN_IF_ERROR(library->Verify());
  std::printf(
      "frames survived by the zero action: mean, least, median, most\n"
      "   Hz  target feed-forwards   | any body 0.25 m off    | mean 0.5 m "
      "off\n");
  for (double hz : {60.0, 120.0, 240.0, 480.0}) {
    for (int i = 0; i < 8; ++i) {
      v1::Action law;
      law.set_ramp((i & 4) != 0);
      law.set_velocity_feedforward((i & 1) != 0);
      law.set_torque_feedforward((i & 2) != 0);
      SINEW_RETURN_IF_ERROR(RunRow(options, *library, hz, law));
    }
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  sinew::Options options;
  CLI::App app("Survival of the zero action by physics rate and action law");
  app.add_option("--library", options.library, "motion library")->required();
  app.add_option("--character", options.character, "name or file");
  app.add_option("--clip", options.clip, "clip name; the first if unset");
  app.add_option("--starts", options.starts, "start phases");
  app.add_option("--seconds", options.seconds, "length for looping clips");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = sinew::RunTable(options);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
