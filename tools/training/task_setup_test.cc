#include "tools/training/task_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

#include "common/blobs/blob_source.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/world/fallen_states.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;

v1::Recipe RecoveryRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(0.5);
  recovery->set_fallen_states(3);
  return WithDefaults(recipe);
}

class TaskSetups : public ::testing::Test {
 protected:
  TaskSetup SetUpToy(const KeptFallenStates& kept = nullptr) const {
    auto setup =
        SetUpTask(toy_.recipe, JoinPath(toy_.folder, "character.textproto"),
                  toy_.library_folder, kept);
    EXPECT_THAT(setup, IsOk());
    return *std::move(setup);
  }
  // States that no other recipe would make: of another seed.
  Blob States(int count) const {
    const auto states = world::FallenStates::Make(*toy_.character, toy_.recipe,
                                                  count, /*seed=*/77);
    EXPECT_THAT(states, IsOk());
    return std::make_shared<const std::string>(states->Serialize());
  }

  const world::testing::ToyWorld toy_ =
      world::testing::MakeToyWorld(RecoveryRecipe());
};

TEST_F(TaskSetups, TellWhatTheLearnerMustKnowOfTheTask) {
  const TaskSetup setup = SetUpToy();

  // Five bodies, four joints; the third joint has a scale of its own.
  EXPECT_EQ(setup.self_observation_width, 13 + 2 * 4 + 3 * 4);
  EXPECT_GT(setup.observation_width, setup.self_observation_width);
  EXPECT_THAT(setup.action_scales, ::testing::ElementsAre(0.2, 0.2, 0.3, 0.2));
}

TEST_F(TaskSetups, HaveFallenStatesWhereTheRecipeStartsFromThem) {
  const TaskSetup setup = SetUpToy();

  const auto states = world::FallenStates::Parse(*setup.assets.at("fallen"),
                                                 *toy_.character, "asset");
  ASSERT_THAT(states, IsOk());
  EXPECT_EQ(states->size(), 3);

  const auto plain = SetUpTask(world::testing::ToyRecipe(),
                               JoinPath(toy_.folder, "character.textproto"),
                               toy_.library_folder, [](const auto&) {
                                 ADD_FAILURE() << "asked for fallen states";
                                 return Blob();
                               });
  ASSERT_THAT(plain, IsOk());
  EXPECT_THAT(plain->assets, Not(Contains(Key("fallen"))));
}

TEST_F(TaskSetups, NeedAGetUpWhereTheRecipeStartsFromThem) {
  v1::Recipe recipe = toy_.recipe;
  recipe.mutable_task()->mutable_recovery()->set_get_up_share(0.5);

  const auto setup = SetUpTask(WithDefaults(recipe),
                               JoinPath(toy_.folder, "character.textproto"),
                               toy_.library_folder, nullptr);

  EXPECT_THAT(setup.status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(toy_.library_folder),
                             HasSubstr("task.recovery.get_up_share"))));
}

// Its one clip that does not leave the floor and loops stays up for any time.
TEST_F(TaskSetups, NeedAFrameThatBodiesCanGoOnAt) {
  const auto set_up = [&](v1::Recipe recipe, double seconds) {
    recipe.mutable_task()->mutable_start()->set_carry_on_seconds(seconds);
    recipe.mutable_task()->mutable_start()->set_carry_on_share(0.5);
    return SetUpTask(WithDefaults(recipe),
                     JoinPath(toy_.folder, "character.textproto"),
                     toy_.library_folder)
        .status();
  };
  v1::Recipe recipe = world::testing::ToyRecipe();
  EXPECT_THAT(set_up(recipe, 100), IsOk());

  recipe.mutable_task()->mutable_start()->add_only_clips("sway");
  EXPECT_THAT(set_up(recipe, 0.5), IsOk());
  EXPECT_THAT(set_up(recipe, 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(toy_.library_folder),
                             HasSubstr("stays up for 1 s (recipe field "
                                       "task.start.carry_on_seconds)"))));
}

// The legs of the toy have no partners.
TEST_F(TaskSetups, NeedAMirrorWhereTheRecipeLearnsFromMirrorImages) {
  for (const char* learner : {"ppo", "distillation"}) {
    v1::Recipe recipe = world::testing::ToyRecipe();
    if (std::string(learner) == "ppo") {
      recipe.mutable_ppo()->set_mirror(true);
    } else {
      recipe.mutable_distillation()->set_mirror(true);
    }
    EXPECT_THAT(SetUpTask(WithDefaults(recipe),
                          JoinPath(toy_.folder, "character.textproto"),
                          toy_.library_folder)
                    .status(),
                StatusIs(absl::StatusCode::kFailedPrecondition,
                         AllOf(HasSubstr("recipe field " +
                                         std::string(learner) + ".mirror"),
                               HasSubstr("mirror_joints"))));
  }
}

TEST_F(TaskSetups, TakeTheFallenStatesThatAreKept) {
  const Blob kept = States(3);
  std::map<std::string, std::string> seen;

  const TaskSetup setup = SetUpToy([&](const auto& others) {
    seen = others;
    return kept;
  });

  EXPECT_EQ(*setup.assets.at("fallen"), *kept);
  EXPECT_NE(setup.assets_sha256, SetUpToy().assets_sha256);
  EXPECT_THAT(seen, AllOf(Contains(Key("character")), Contains(Key("model")),
                          Contains(Key("recipe"))));
  EXPECT_EQ(seen["model"], *setup.assets.at("model"));
}

TEST_F(TaskSetups, MakeFallenStatesAnewWhereTheKeptOnesDoNotFit) {
  const std::string made = *SetUpToy().assets.at("fallen");
  const Blob nonsense = std::make_shared<const std::string>("nonsense");

  for (const Blob& kept : {Blob(), nonsense, States(2)}) {
    const TaskSetup setup = SetUpToy([&](const auto&) { return kept; });

    EXPECT_EQ(*setup.assets.at("fallen"), made);
  }
}

TEST_F(TaskSetups, NeedAClipThatIsTrainedOn) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  for (const int clip : {0, 1, 2}) {
    world::testing::LeaveOutOnDisk(clip, toy.library_folder);
  }

  EXPECT_THAT(
      SetUpTask(toy.recipe, JoinPath(toy.folder, "character.textproto"),
                toy.library_folder),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr(toy.library_folder),
                     HasSubstr("found none among 3 that is not left out"))));
}

}  // namespace
}  // namespace sinew::tools
