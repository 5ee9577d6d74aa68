#include "tools/training/run_teacher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "sim/world/observation.h"
#include "sim/world/testing/toy_world.h"
#include "teacher/client/testing/fake_teacher.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

world::ObservationBuilder Observing(const v1::Observation& recipe) {
  return world::ObservationBuilder::Create(recipe, /*bodies=*/1, /*joints=*/2,
                                           /*feet=*/0)
      .value();
}

// A run and a teacher that fit each other: both observe 17 columns of the body
// and 19 of the reference.
struct Fitting {
  Fitting() {
    recipe.mutable_task()->mutable_observation()->add_frames_ahead(1);
    v1::Action& action =
        *recipe.mutable_distillation()->mutable_teacher_action();
    action.set_scale(0.2);
    recipe.mutable_physics()->set_control_hz(30);
    setup.character_sha256 = "body";
    setup.observation = std::make_shared<const world::ObservationBuilder>(
        Observing(recipe.task().observation()));
    setup.observation_width = setup.observation->width();
    setup.action_width = 2;
    teacher.set_control_hz(30);
    teacher.set_character_sha256("body");
    teacher.set_observation_width(setup.observation_width);
    teacher.set_action_width(2);
    *teacher.mutable_observation() = recipe.task().observation();
    *teacher.mutable_action() = action;
  }

  absl::StatusOr<std::vector<int32_t>> Columns() const {
    return CheckTeacher("bundles/expert", teacher, recipe, setup);
  }
  absl::Status Check() const { return Columns().status(); }

  v1::Recipe recipe;
  TaskSetup setup;
  v1::DescribeTeacherResponse teacher;
};

TEST(RunTeacher, TakesATeacherThatFits) {
  std::vector<int32_t> all(36);
  std::iota(all.begin(), all.end(), 0);

  EXPECT_THAT(Fitting().Columns(), IsOkAndHolds(all));
}

TEST(RunTeacher, SeesMaybeLessThanItsStudent) {
  Fitting run;
  v1::Observation& observation =
      *run.recipe.mutable_task()->mutable_observation();
  for (const auto block : {v1::Observation::BLOCK_SELF_JOINT_SPACE,
                           v1::Observation::BLOCK_PREVIOUS_TARGET,
                           v1::Observation::BLOCK_REFERENCE_DIFFERENCE}) {
    observation.add_blocks(block);
  }
  run.setup.observation =
      std::make_shared<const world::ObservationBuilder>(Observing(observation));

  // All but the two columns of the previous target.
  std::vector<int32_t> expected(36);
  std::iota(expected.begin(), expected.begin() + 17, 0);
  std::iota(expected.begin() + 17, expected.end(), 19);
  EXPECT_THAT(run.Columns(), IsOkAndHolds(expected));
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
       "observation_width: expected 36, found 6"},
      {[](auto& teacher) { teacher.set_action_width(3); },
       "action_width: expected 2, found 3"},
      {[](auto& teacher) {
         teacher.mutable_observation()->set_frames_ahead(0, 4);
       },
       "observation: expected blocks and frames among the recipe's"},
      {[](auto& teacher) {
         teacher.mutable_observation()->set_frames_ahead(0, 0);
       },
       "its observation: recipe field task.observation.frames_ahead[0]: "
       "expected >= 1, found 0"},
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

}  // namespace
}  // namespace sinew::tools
