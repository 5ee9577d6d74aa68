#include "tools/training/run_teacher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "teacher/client/testing/fake_teacher.h"

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

// A run and a teacher that fit each other.
struct Fitting {
  Fitting() {
    recipe.mutable_task()->mutable_observation()->add_frames_ahead(1);
    v1::Action& action =
        *recipe.mutable_distillation()->mutable_teacher_action();
    action.set_scale(0.2);
    recipe.mutable_physics()->set_control_hz(30);
    setup.character_sha256 = "body";
    setup.observation_width = 5;
    setup.action_width = 2;
    teacher.set_control_hz(30);
    teacher.set_character_sha256("body");
    teacher.set_observation_width(5);
    teacher.set_action_width(2);
    *teacher.mutable_observation() = recipe.task().observation();
    *teacher.mutable_action() = action;
  }

  absl::Status Check() const {
    return CheckTeacher("bundles/expert", teacher, recipe, setup);
  }

  v1::Recipe recipe;
  TaskSetup setup;
  v1::DescribeTeacherResponse teacher;
};

TEST(RunTeacher, TakesATeacherThatFits) {
  EXPECT_THAT(Fitting().Check(), IsOk());
}

TEST(RunTeacher, NamesTheFieldThatDoesNotFitAndBothValues) {
  using Edit = std::function<void(v1::DescribeTeacherResponse&)>;
  const std::pair<Edit, std::string> cases[] = {
      {[](auto& teacher) { teacher.set_control_hz(60); },
       "control_hz: expected 30, found 60"},
      {[](auto& teacher) { teacher.clear_control_hz(); },
       "control_hz: expected 30, found none"},
      {[](auto& teacher) { teacher.set_character_sha256("another"); },
       "character_sha256: expected body, found another"},
      {[](auto& teacher) { teacher.set_observation_width(6); },
       "observation_width: expected 5, found 6"},
      {[](auto& teacher) { teacher.set_action_width(3); },
       "action_width: expected 2, found 3"},
      {[](auto& teacher) {
         teacher.mutable_observation()->set_frames_ahead(0, 4);
       },
       "observation: expected the recipe's"},
      {[](auto& teacher) { teacher.mutable_action()->set_scale(0.5); },
       "distillation.teacher_action"}};
  for (const auto& [edit, message] : cases) {
    Fitting run;
    edit(run.teacher);

    EXPECT_THAT(run.Check(), StatusIs(absl::StatusCode::kInvalidArgument,
                                      AllOf(HasSubstr("bundles/expert"),
                                            HasSubstr(message))));
  }
}

TEST(RunTeacher, IsThereWhereTheRecipeHasDistillationAndOnlyThere) {
  Fitting run;
  EXPECT_THAT(OpenTeacher({.teachers = {}}, run.recipe, run.setup).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--teacher: expected a bundle")));
  run.recipe.clear_distillation();
  EXPECT_THAT(
      OpenTeacher({.teachers = {"bundles/expert"}}, run.recipe, run.setup)
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("--teacher: expected none")));

  const auto none = OpenTeacher({.teachers = {}}, run.recipe, run.setup);
  ASSERT_THAT(none.status(), IsOk());
  EXPECT_FALSE(none->has_value());
}

TEST(RunTeacher, OfABundleHasTheControlRateOfTheTask) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());
  v1::Recipe recipe = toy.recipe;
  recipe.mutable_distillation();
  recipe.mutable_physics()->set_control_hz(60);

  EXPECT_THAT(OpenTeacher({.teachers = {bundle}}, recipe, TaskSetup()).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(bundle),
                             HasSubstr("control_hz: expected 60, found 30"))));
}

TEST(RunTeacher, ThatActsInAShareOfEpisodesIsABundleHere) {
  Fitting run;
  run.recipe.mutable_distillation()->set_teacher_share(0.25);

  EXPECT_THAT(OpenTeacher({.teachers = {"unix:/nobody"}}, run.recipe, run.setup)
                  .status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("distillation.teacher_share"),
                             HasSubstr("found 0.25 and unix:/nobody"))));
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
  // What the teacher says of one row of a clip.
  std::vector<double> Target(const RunTeacher& teacher, int clip) const {
    const std::vector<float> observations(setup.observation_width, 0.5F);
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

TEST(RunTeacher, OfSeveralBundlesEachLabelsTheClipsThatItNames) {
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

TEST(RunTeacher, OfABundleOfAFewClipsOfItsLibraryAreThoseItsOwn) {
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

TEST(RunTeacher, OfSeveralBundlesEachLabelsTheClipsThatItSaysItWasTrainedOn) {
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

TEST(RunTeacher, OfSeveralBundlesLabelsNoClipThatNoneWasTrainedOn) {
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

TEST(RunTeacher, OfSeveralBundlesActsInNoEpisodes) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]});
  const std::string rest = run.Bundle("rest", {clips.begin() + 1, clips.end()});
  run.recipe.mutable_distillation()->set_teacher_share(0.25);

  EXPECT_THAT(run.Open({first, rest}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("distillation.teacher_share")));
}

TEST(RunTeacher, OfSeveralBundlesLabelsEveryClip) {
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

TEST(RunTeacher, OfBundlesOfOneClipTheNarrowestLabelsIt) {
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

TEST(RunTeacher, RefusesBundlesThatKnowAClipEquallyWell) {
  Several run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  ASSERT_EQ(clips.size(), 3u);
  const std::string all = run.Bundle("all", clips);
  const std::string front = run.Bundle("front", {clips[0], clips[1]}, 0.3);
  const std::string back = run.Bundle("back", {clips[1], clips[2]}, 0.6);

  EXPECT_THAT(run.Open({all, front, back}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("clip " + clips[1]), HasSubstr(front),
                             HasSubstr(back), HasSubstr("2 clips each"))));
  // Of what no start is drawn from, either may know more.
  Several elsewhere;
  v1::Start& start = *elsewhere.recipe.mutable_task()->mutable_start();
  start.add_only_clips(clips[0]);
  start.add_only_clips(clips[2]);
  EXPECT_THAT(elsewhere.Open({all, front, back}), IsOk());
  // A bundle of that clip alone settles it.
  EXPECT_THAT(
      run.Open({all, front, back, run.Bundle("middle", {clips[1]}, 0.45)}),
      IsOk());
}

// The first call is never answered; without a time of its own it would last as
// long as patience does.
TEST(RunTeacher, ElsewhereHasSoLongForACallAsItIsGiven) {
  using teacher::testing::FakeTeacher;
  Fitting run;
  const rpc::SocketFolder folder;
  const std::string address = folder.Address("teacher");
  FakeTeacher teacher(
      [](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
        if (call == 0) teacher::testing::AwaitCancellation(context);
        return grpc::Status::OK;
      });
  const auto server = rpc::Server::Start({.address = address}, {&teacher});
  ASSERT_THAT(server.status(), IsOk());

  EXPECT_THAT(OpenTeacher({.teachers = {address},
                           .patience = absl::Seconds(20),
                           .timeout = absl::Milliseconds(100)},
                          run.recipe, run.setup)
                  .status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(address), HasSubstr("control_hz"))));
  EXPECT_GE(teacher.calls(), 2);
}

TEST(RunTeacher, IsBundlesOrAddressesNotBoth) {
  Several run;
  const std::string first = run.Bundle("first", {"turn"});

  EXPECT_THAT(run.Open({first, "unix:/nobody"}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("folders (" + first),
                             HasSubstr("none (unix:/nobody"))));
}

}  // namespace
}  // namespace sinew::tools
