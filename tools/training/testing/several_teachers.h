#ifndef SINEW_TOOLS_TRAINING_TESTING_SEVERAL_TEACHERS_H_
#define SINEW_TOOLS_TRAINING_TESTING_SEVERAL_TEACHERS_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/training/run_teacher.h"
#include "tools/training/task_setup.h"

namespace sinew::tools::testing {

inline std::vector<std::string> ClipNames(const motion::Library& library) {
  std::vector<std::string> names;
  for (int c = 0; c < library.num_clips(); ++c) {
    names.push_back(library.clip(c).name());
  }
  return names;
}

// A run of the toy's task, and bundles that could teach it.
struct SeveralTeachers {
  SeveralTeachers() {
    recipe = toy.recipe;
    recipe.mutable_distillation();
    *recipe.mutable_distillation()->mutable_teacher_action() =
        recipe.task().action();
    recipe = WithDefaults(recipe);
    const auto set_up =
        SetUpTask(recipe, JoinPath(toy.folder, "character.textproto"),
                  toy.library_folder);
    EXPECT_THAT(set_up, ::sinew::testing::IsOk());
    setup = *set_up;
  }

  // A bundle that names these clips, and says what they were to its training;
  // by default nothing, as bundles of old versions.
  std::string Bundle(const std::string& name,
                     const std::vector<std::string>& clips, double gain = 0.3,
                     const std::vector<std::string>& only = {},
                     const std::vector<v1::ClipUse>& uses = {}) {
    bundle::BundleContent content = bundle::testing::ToyContent(toy, gain);
    v1::BundleProvenance& provenance = *content.manifest.mutable_provenance();
    provenance.clear_clips();
    for (const std::string& clip : clips) {
      provenance.add_clips(clip + ": made for tests (Apache-2.0)");
    }
    provenance.clear_clip_uses();
    for (const v1::ClipUse use : uses) provenance.add_clip_uses(use);
    v1::Start& start = *content.manifest.mutable_task()->mutable_start();
    for (const std::string& clip : only) start.add_only_clips(clip);
    const std::string folder = JoinPath(toy.folder, name);
    EXPECT_THAT(bundle::WriteBundle(content, folder), ::sinew::testing::IsOk());
    return folder;
  }
  // A file of what `sinew eval` says of a bundle that wins so many of the one
  // start of each clip.
  std::string Evaluation(const std::string& bundle,
                         const std::vector<int>& won) const {
    const std::string file = bundle + ".json";
    EXPECT_THAT(evaluation::EvaluateBundle(bundle, toy.library_folder, file,
                                           {.starts = 1, .seconds = 0.2}, {})
                    .status(),
                ::sinew::testing::IsOk());
    nlohmann::json json = nlohmann::json::parse(*ReadFile(file));
    for (size_t c = 0; c < won.size(); ++c) {
      json["clips"][c]["succeeded_starts"] = won[c];
    }
    EXPECT_THAT(WriteFileAtomically(file, json.dump()),
                ::sinew::testing::IsOk());
    return file;
  }
  // What the teacher says of one row of a clip.
  std::vector<double> Target(const RunTeacher& teacher, int clip) const {
    return Target(teacher, clip,
                  std::vector<float>(setup.observation_width, 0.5F));
  }
  std::vector<double> Target(const RunTeacher& teacher, int clip,
                             const std::vector<float>& observations) const {
    const std::vector<double> bases(setup.action_width, 0.01);
    const std::vector<int32_t> clips = {clip};
    std::vector<double> targets(bases.size());
    EXPECT_THAT(
        teacher.annotator->Annotate(
            {.observations = observations, .bases = bases, .clips = clips},
            absl::MakeSpan(targets)),
        ::sinew::testing::IsOk());
    return targets;
  }
  absl::StatusOr<std::optional<RunTeacher>> Open(
      const std::vector<std::string>& teachers) const {
    return OpenTeacher({.teachers = teachers}, recipe, setup);
  }

  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  v1::Recipe recipe;
  TaskSetup setup;
};

}  // namespace sinew::tools::testing

#endif  // SINEW_TOOLS_TRAINING_TESTING_SEVERAL_TEACHERS_H_
