#include "tools/training/testing/several_teachers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/clock.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "teacher/service/teacher_server.h"
#include "tools/teacher/read_teacher.h"
#include "tools/training/run_teacher.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::ClipNames;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::SeveralTeachers;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

TEST(SeveralTeachersTest, EachLabelsTheClipsThatItNames) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, OfABundleOfAFewClipsOfItsLibraryAreThoseItsOwn) {
  SeveralTeachers run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", clips, 0.3, {clips[0]});
  const std::string rest =
      run.Bundle("rest", clips, 0.6, {clips.begin() + 1, clips.end()});

  const auto teacher = run.Open({rest, first});

  ASSERT_THAT(teacher, IsOk());
  EXPECT_EQ(run.Target(**teacher, 0), run.Target(**run.Open({first}), 0));
  EXPECT_EQ(run.Target(**teacher, 1), run.Target(**run.Open({rest}), 1));
}

TEST(SeveralTeachersTest, EachLabelsTheClipsThatItSaysItWasTrainedOn) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, LabelsNoClipThatNoneWasTrainedOn) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, ActsInNoEpisodes) {
  SeveralTeachers run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]});
  const std::string rest = run.Bundle("rest", {clips.begin() + 1, clips.end()});
  run.recipe.mutable_distillation()->set_teacher_share(0.25);

  EXPECT_THAT(run.Open({first, rest}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("distillation.teacher_share")));
}

TEST(SeveralTeachersTest, LabelsEveryClip) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, OfBundlesOfOneClipTheNarrowestLabelsIt) {
  SeveralTeachers run;
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
TEST(SeveralTeachersTest, EachLabelsWhatItsEvaluationSaysItDoesBestAt) {
  SeveralTeachers run;
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

// One bundle has two replicas.
TEST(SeveralTeachersTest, ElsewhereLabelAsTheyDoHere) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, AreNamedByFoldersThatAreThereOrAddresses) {
  SeveralTeachers run;
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
TEST(SeveralTeachersTest, ByEvaluationsAreThoseThatDoBestAtAClip) {
  SeveralTeachers run;
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

TEST(SeveralTeachersTest, HasEvaluationsOnlyWhereThereAreBundlesToChooseFrom) {
  SeveralTeachers run;
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
