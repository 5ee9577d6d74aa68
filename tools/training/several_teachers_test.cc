#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "teacher/service/teacher_server.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/teacher/read_teacher.h"
#include "tools/training/run_teacher.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

std::vector<std::string> ClipNames(const motion::Library& library) {
  std::vector<std::string> names;
  for (int c = 0; c < library.num_clips(); ++c) {
    names.push_back(library.clip(c).name());
  }
  return names;
}

// A run of the toy's task, and bundles that could teach it.
struct Several {
  Several() {
    recipe = toy.recipe;
    recipe.mutable_distillation();
    *recipe.mutable_distillation()->mutable_teacher_action() =
        recipe.task().action();
    recipe = WithDefaults(recipe);
    const auto set_up =
        SetUpTask(recipe, JoinPath(toy.folder, "character.textproto"),
                  toy.library_folder);
    EXPECT_THAT(set_up, IsOk());
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
    EXPECT_THAT(bundle::WriteBundle(content, folder), IsOk());
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
                IsOk());
    nlohmann::json json = nlohmann::json::parse(*ReadFile(file));
    for (size_t c = 0; c < won.size(); ++c) {
      json["clips"][c]["succeeded_starts"] = won[c];
    }
    EXPECT_THAT(WriteFileAtomically(file, json.dump()), IsOk());
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
        IsOk());
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

TEST(SeveralTeachers, EachLabelsTheClipsThatItNames) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_GE(clips.size(), 2u);
  const std::string first = run.Bundle("first", {clips[0]});
  const std::string rest =
      run.Bundle("rest", {clips.begin() + 1, clips.end()}, /*gain=*/0.6);

  const auto teacher = run.Open({first, rest});

  ASSERT_THAT(teacher, IsOk());
  ASSERT_TRUE(teacher->has_value());
  const RunTeacher& found = **teacher;
  ASSERT_EQ(found.sources.size(), 2u);
  EXPECT_EQ(found.sources[0].bundle().role(), "teacher");
  EXPECT_THAT(found.sources[0].clips(),
              ElementsAre(HasSubstr(clips[0] + ": ")));
  EXPECT_NE(found.sources[0].bundle().manifest_sha256(),
            found.sources[1].bundle().manifest_sha256());
  EXPECT_FALSE(found.add_graph);
  // The same row of either clip, and what each bundle says of it alone.
  EXPECT_EQ(run.Target(found, 0), run.Target(**run.Open({first}), 0));
  EXPECT_EQ(run.Target(found, 1), run.Target(**run.Open({rest}), 1));
  EXPECT_NE(run.Target(found, 0), run.Target(found, 1));
}

TEST(SeveralTeachers, OfABundleOfAFewClipsOfItsLibraryAreThoseItsOwn) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", clips, 0.3, {clips[0]});
  const std::string rest =
      run.Bundle("rest", clips, 0.6, {clips.begin() + 1, clips.end()});

  const auto teacher = run.Open({rest, first});

  ASSERT_THAT(teacher, IsOk());
  EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({first}), 0));
  EXPECT_EQ(run.Target(**teacher, 1), run.Target(**run.Open({rest}), 1));
}

TEST(SeveralTeachers, EachLabelsTheClipsThatItSaysItWasTrainedOn) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_EQ(clips.size(), 3u);
  const std::string first =
      run.Bundle("first", clips, 0.3, {},
                 {v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_LEFT_OUT,
                  v1::CLIP_USE_SOURCE_TRAINED_ON});
  const std::string rest =
      run.Bundle("rest", clips, 0.6, {},
                 {v1::CLIP_USE_LEFT_OUT, v1::CLIP_USE_TRAINED_ON,
                  v1::CLIP_USE_TRAINED_ON});

  const auto teacher = run.Open({first, rest});

  ASSERT_THAT(teacher, IsOk());
  EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({first}), 0));
  EXPECT_EQ(run.Target(**teacher, 1), run.Target(**run.Open({rest}), 1));
  EXPECT_EQ(run.Target(**teacher, 2), run.Target(**run.Open({rest}), 2));
  EXPECT_NE(run.Target(**teacher, 0), run.Target(**teacher, 1));
}

TEST(SeveralTeachers, LabelsNoClipThatNoneWasTrainedOn) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_EQ(clips.size(), 3u);
  const std::string first = run.Bundle(
      "first", clips, 0.3, {},
      {v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_LEFT_OUT, v1::CLIP_USE_LEFT_OUT});
  const std::string second = run.Bundle(
      "second", clips, 0.6, {},
      {v1::CLIP_USE_UNKNOWN, v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_LEFT_OUT});

  EXPECT_THAT(run.Open({first, second}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("trained on clip " + clips[2]),
                             HasSubstr(first), HasSubstr(second))));
  // Where no start is drawn from it, nobody needs to.
  v1::Start& start = *run.recipe.mutable_task()->mutable_start();
  start.add_only_clips(clips[0]);
  start.add_only_clips(clips[1]);
  EXPECT_THAT(run.Open({first, second}), IsOk());
}

TEST(SeveralTeachers, ActsInNoEpisodes) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]});
  const std::string rest = run.Bundle("rest", {clips.begin() + 1, clips.end()});
  run.recipe.mutable_distillation()->set_teacher_share(0.25);

  EXPECT_THAT(run.Open({first, rest}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("distillation.teacher_share")));
}

TEST(SeveralTeachers, LabelsEveryClip) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]});
  const std::string other = run.Bundle("other", {"another"});

  EXPECT_THAT(run.Open({first, other}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("clip " + clips[1]), HasSubstr(first),
                             HasSubstr(other))));
  // What no start is drawn from needs no teacher.
  run.recipe.mutable_task()->mutable_start()->add_only_clips(clips[0]);
  EXPECT_THAT(run.Open({first, other}), IsOk());
}

TEST(SeveralTeachers, OfBundlesOfOneClipTheNarrowestLabelsIt) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string all = run.Bundle("all", clips, /*gain=*/0.3);
  const std::string first = run.Bundle("first", {clips[0]}, /*gain=*/0.6);

  for (const auto& order : {std::vector{all, first}, std::vector{first, all}}) {
    const auto teacher = run.Open(order);
    ASSERT_THAT(teacher, IsOk());
    EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({first}), 0));
    EXPECT_EQ(run.Target(**teacher, 1), run.Target(**run.Open({all}), 1));
    EXPECT_NE(run.Target(**teacher, 0), run.Target(**run.Open({all}), 0));
  }
}

// The evaluations are real ones, but for who wins.
TEST(SeveralTeachers, EachLabelsWhatItsEvaluationSaysItDoesBestAt) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_EQ(clips.size(), 3u);
  const std::string first = run.Bundle("first", clips, /*gain=*/0.3);
  const std::string second = run.Bundle("second", clips, /*gain=*/0.6);
  RunTeacherOptions options = {
      .teachers = {first, second},
      .evaluations = {run.Evaluation(second, {0, 1, 0}),
                      run.Evaluation(first, {1, 0, 1})}};

  const auto teacher = OpenTeacher(options, run.recipe, run.setup);

  ASSERT_THAT(teacher, IsOk());
  EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({first}), 0));
  EXPECT_EQ(run.Target(**teacher, 1), run.Target(**run.Open({second}), 1));
  EXPECT_THAT((*teacher)->sources[0].labelled_clips(),
              ElementsAre(clips[0], clips[2]));
  EXPECT_THAT((*teacher)->sources[1].labelled_clips(), ElementsAre(clips[1]));
  // By their training, they are equally good at all.
  options.evaluations.clear();
  EXPECT_THAT(OpenTeacher(options, run.recipe, run.setup).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--teacher-eval")));
}

// The student sees its previous target as well, which no teacher does.
TEST(SeveralTeachers, MaySeeLessThanTheStudent) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]}, /*gain=*/0.3);
  const std::string rest =
      run.Bundle("rest", {clips.begin() + 1, clips.end()}, /*gain=*/0.6);
  const auto narrow = run.Open({first, rest});
  ASSERT_THAT(narrow, IsOk());
  std::vector<float> seen(run.setup.observation_width);
  for (size_t i = 0; i < seen.size(); ++i) {
    seen[i] = 0.01F * static_cast<float>(i);
  }
  const std::vector<double> of_first = run.Target(**narrow, 0, seen);
  const std::vector<double> of_rest = run.Target(**narrow, 1, seen);
  ASSERT_NE(of_first, of_rest);
  const int own = run.setup.self_observation_width;
  v1::Observation& observation =
      *run.recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  for (const auto block : {v1::Observation::BLOCK_SELF_JOINT_SPACE,
                           v1::Observation::BLOCK_PREVIOUS_TARGET,
                           v1::Observation::BLOCK_REFERENCE_DIFFERENCE}) {
    observation.add_blocks(block);
  }
  const auto set_up =
      SetUpTask(run.recipe, JoinPath(run.toy.folder, "character.textproto"),
                run.toy.library_folder);
  ASSERT_THAT(set_up, IsOk());
  run.setup = *set_up;
  // What the previous target is, the teachers do not mind.
  std::vector<float> wide = seen;
  wide.insert(wide.begin() + own, run.setup.action_width, 7.0F);
  ASSERT_EQ(static_cast<int>(wide.size()), run.setup.observation_width);

  const auto both = run.Open({first, rest});
  ASSERT_THAT(both, IsOk());
  EXPECT_EQ(run.Target(**both, 0, wide), of_first);
  EXPECT_EQ(run.Target(**both, 1, wide), of_rest);
  const auto alone = run.Open({rest});
  ASSERT_THAT(alone, IsOk());
  EXPECT_EQ(run.Target(**alone, 0, wide), of_rest);
  // By what it sees an actor could not let it act.
  run.recipe.mutable_distillation()->set_teacher_share(0.25);
  EXPECT_THAT(run.Open({first}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("distillation.teacher_share"),
                             HasSubstr("does not observe all"))));
}

// One bundle has two replicas.
TEST(SeveralTeachers, ElsewhereLabelAsTheyDoHere) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_EQ(clips.size(), 3u);
  const std::string first = run.Bundle("first", {clips[0]}, /*gain=*/0.3);
  const std::string rest =
      run.Bundle("rest", {clips[1], clips[2]}, /*gain=*/0.6);
  const rpc::SocketFolder sockets;
  SystemClock clock;
  const auto serve = [&](const std::string& bundle, const std::string& name) {
    return teacher::TeacherServer::Create({.address = sockets.Address(name)},
                                          teacher::ReadTeacher(bundle).value(),
                                          clock)
        .value();
  };
  const auto a = serve(rest, "a"), b = serve(first, "b"), c = serve(rest, "c");
  const std::string replicas = a->address() + "," + c->address();
  const auto here = run.Open({first, rest});
  ASSERT_THAT(here, IsOk());

  for (const auto& teachers :
       {std::vector{replicas, b->address()}, std::vector{replicas, first}}) {
    const auto there = run.Open(teachers);
    ASSERT_THAT(there, IsOk());
    for (int clip = 0; clip < 3; ++clip) {
      EXPECT_EQ(run.Target(**there, clip), run.Target(**here, clip));
    }
    ASSERT_EQ((*there)->sources.size(), 2u);
    EXPECT_THAT((*there)->sources[0].labelled_clips(),
                ElementsAre(clips[1], clips[2]));
    EXPECT_EQ((*there)->sources[0].bundle().manifest_sha256(),
              (*here)->sources[1].bundle().manifest_sha256());
  }
  EXPECT_THAT(
      run.Open({a->address(), c->address()}),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("found the same"), HasSubstr(a->address()),
                     HasSubstr(c->address()), HasSubstr("commas"))));
}

TEST(SeveralTeachers, AreNamedByFoldersThatAreThereOrAddresses) {
  Several run;
  const std::string there = run.Bundle("there", {"turn"});
  for (const std::string& name :
       {there + "s", std::string("unix:/a,") + there}) {
    EXPECT_THAT(run.Open({there, name}),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("--teacher " + name),
                               HasSubstr("folder of a bundle"))));
  }
}

// What another bundle does better throughout is not learned from, nor kept.
TEST(SeveralTeachers, ByEvaluationsAreThoseThatDoBestAtAClip) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string best = run.Bundle("best", clips, /*gain=*/0.3);
  const std::string worse = run.Bundle("worse", clips, /*gain=*/0.6);

  const auto teacher =
      OpenTeacher({.teachers = {worse, best},
                   .evaluations = {run.Evaluation(best, {1, 1, 1}),
                                   run.Evaluation(worse, {0, 0, 0})}},
                  run.recipe, run.setup);

  ASSERT_THAT(teacher, IsOk());
  EXPECT_TRUE((*teacher)->by_evaluation);
  ASSERT_EQ((*teacher)->sources.size(), 1u);
  EXPECT_EQ((*teacher)->sources[0].labelled_clips_size(), 3);
  EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({best}), 0));
}

TEST(SeveralTeachers, HasEvaluationsOnlyWhereThereAreBundlesToChooseFrom) {
  Several run;
  const std::string only = run.Bundle("only", {"turn", "sway", "tumble"});

  EXPECT_THAT(OpenTeacher({.teachers = {only}, .evaluations = {"e.json"}},
                          run.recipe, run.setup)
                  .status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("--teacher-eval: expected none"),
                             HasSubstr("e.json"))));
}

}  // namespace
}  // namespace sinew::tools
