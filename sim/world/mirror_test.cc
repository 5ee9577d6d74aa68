#include "sim/world/mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/library_maker.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

v1::Recipe AllBlocks() {
  v1::Recipe recipe;
  auto* observation = recipe.mutable_task()->mutable_observation();
  for (const auto block : {v1::Observation::BLOCK_SELF_JOINT_SPACE,
                           v1::Observation::BLOCK_REFERENCE_DIFFERENCE,
                           v1::Observation::BLOCK_PREVIOUS_TARGET,
                           v1::Observation::BLOCK_REFERENCE_CONTACT,
                           v1::Observation::BLOCK_SELF_CONTACT,
                           v1::Observation::BLOCK_REFERENCE_KEYPOINTS,
                           v1::Observation::BLOCK_REFERENCE_BODIES,
                           v1::Observation::BLOCK_SELF_BODIES}) {
    observation->add_blocks(block);
  }
  observation->add_frames_ahead(1);
  observation->add_frames_ahead(2);
  return WithDefaults(recipe);
}

// A humanoid with two clips: poses drawn at random, and their mirror images.
class HumanoidMirrorTest : public ::testing::Test {
 protected:
  HumanoidMirrorTest() {
    const v1::Recipe recipe = AllBlocks();
    auto loaded = character::Character::Load("humanoid", recipe.physics());
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    character_ = *std::move(loaded);
    data_.reset(mj_makeData(character_->model()));
    testing::LibraryMaker maker(*character_);
    for (const bool mirrored : {false, true}) {
      v1::ClipInfo clip;
      clip.set_name(mirrored ? "mirrored" : "drawn");
      maker.BeginClip(clip);
      for (uint64_t frame = 0; frame < 4; ++frame) {
        SetPose(frame, mirrored);
        maker.AddFrame(data_.get(), /*contact=*/frame % 2 == 0);
      }
    }
    library_ = maker.Make(testing::NewFolder());
    auto task = TrackingTask::Create(recipe, *character_, *library_);
    EXPECT_TRUE(task.ok()) << task.status();
    task_ = *std::move(task);
  }

  // A random state, the same for equal `seed`; or its image under y -> -y.
  void SetPose(uint64_t seed, bool mirrored) {
    const int joints = static_cast<int>(character_->joints().size());
    std::vector<float> noise(13 + 2 * joints);
    FillNormal({.seed = seed}, absl::MakeSpan(noise));
    const float side = mirrored ? -1 : 1;
    double* q = data_->qpos;
    double* v = data_->qvel;
    const double place[3] = {noise[0], side * noise[1], 1.2 + 0.1 * noise[2]};
    // S R S keeps the turn about y and reverses those about x and z.
    const double turn[4] = {1 + noise[3], side * noise[4], noise[5],
                            side * noise[6]};
    const double rates[6] = {noise[7],  side * noise[8],
                             noise[9],  side * noise[10],
                             noise[11], side * noise[12]};
    mju_copy(q, place, 3);
    mju_copy(q + 3, turn, 4);
    mju_normalize4(q + 3);
    mju_copy(v, rates, 6);
    std::map<std::string, std::pair<double, double>> drawn;
    for (int j = 0; j < joints; ++j) {
      drawn[character_->joints()[j].name] = {0.3 * noise[13 + j],
                                             noise[13 + joints + j]};
    }
    std::map<std::string, std::pair<std::string, double>> partner;
    for (const v1::MirrorPair& pair : character_->proto().mirror_joints()) {
      partner[pair.left()] = {pair.right(), pair.sign()};
      partner[pair.right()] = {pair.left(), pair.sign()};
    }
    for (const character::JointInfo& joint : character_->joints()) {
      const auto [name, sign] =
          mirrored ? partner.at(joint.name) : std::pair{joint.name, 1.0};
      q[joint.qpos_address] = sign * drawn.at(name).first;
      v[joint.dof_address] = sign * drawn.at(name).second;
    }
    mj_forward(character_->model(), data_.get());
  }

  // What the policy sees in state `seed` at the start of a clip.
  std::vector<float> Observe(int clip, uint64_t seed, bool mirrored,
                             const std::vector<double>& previous_target) {
    SetPose(seed, mirrored);
    const auto work = task_->MakeWorkspace();
    task_->Refresh(data_.get(), work.get());
    std::vector<float> observation(task_->observation_width());
    task_->Observe(data_.get(), {.clip = clip}, previous_target,
                   absl::MakeSpan(observation), work.get());
    return observation;
  }

  std::unique_ptr<const character::Character> character_;
  character::DataPtr data_;
  std::unique_ptr<const motion::Library> library_;
  std::unique_ptr<const TrackingTask> task_;
};

TEST_F(HumanoidMirrorTest, ObservationsOfAMirroredWorldAreMirrored) {
  const auto mirror = MakeMirror(*task_);
  ASSERT_TRUE(mirror.ok()) << mirror.status();
  const int joints = mirror->action.width();
  std::vector<double> target(joints), mirrored_target(joints);
  for (int j = 0; j < joints; ++j) target[j] = 0.01 * j;
  for (int j = 0; j < joints; ++j) {
    mirrored_target[j] =
        mirror->action.sign[j] * target[mirror->action.source[j]];
  }

  for (const uint64_t seed : {100, 101, 102}) {
    const auto plain = Observe(/*clip=*/0, seed, /*mirrored=*/false, target);
    const auto image =
        Observe(/*clip=*/1, seed, /*mirrored=*/true, mirrored_target);

    std::vector<float> expected(plain.size());
    mirror->observation.Apply(plain, absl::MakeSpan(expected));
    const std::vector<std::string> names = task_->ObservationNames();
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(image[i], expected[i], 2e-4) << names[i];
    }
  }
}

TEST_F(HumanoidMirrorTest, NeedsEqualDrivesLeftAndRight) {
  std::string left;
  for (const v1::MirrorPair& pair : character_->proto().mirror_joints()) {
    if (pair.left() != pair.right()) left = pair.left();
  }
  ASSERT_FALSE(left.empty());
  v1::Recipe recipe = task_->recipe();
  auto* model = recipe.mutable_task()->mutable_actuator_model();
  model->add_drives();
  model->add_drives()->add_joints(left);
  recipe = WithDefaults(recipe);
  const auto make = [&] {
    const auto task = TrackingTask::Create(recipe, *character_, *library_);
    EXPECT_TRUE(task.ok()) << task.status();
    return MakeMirror(**task).status();
  };
  EXPECT_TRUE(make().ok()) << make();

  recipe.mutable_task()
      ->mutable_actuator_model()
      ->mutable_drives(1)
      ->set_static_friction(1);
  EXPECT_THAT(make(), StatusIs(absl::StatusCode::kFailedPrecondition,
                               HasSubstr("action scales and drives")));
}

// The mirror of the toy with equal legs, the frame of one turned by `pitch`
// about its hinge, where the policy sees this block; `hinge`: more of that one.
absl::Status MirrorTable(double pitch, v1::Observation::Block block,
                         const std::string& hinge = "") {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const std::string text_file = JoinPath(toy.folder, "character.textproto");
  const std::string model_file = JoinPath(toy.folder, "toy.xml");
  std::string text = *ReadFile(text_file);
  EXPECT_EQ(
      absl::StrReplaceAll({{"stiffness: 100 damping: 8 torque_limit: 50",
                            "stiffness: 200 damping: 10 torque_limit: 60"},
                           {"default_position: 0.1 action_scale: 0.3", ""}},
                          &text),
      2);
  for (const char* legs : {"f", "b"}) {
    absl::StrAppend(&text, "mirror_joints { left: \"hip_", legs,
                    "l\" right: \"hip_", legs, "r\" sign: 1 }\n",
                    "mirror_bodies { left: \"leg_", legs, "l\" right: \"leg_",
                    legs, "r\" sign: 1 }\n");
  }
  std::string model = *ReadFile(model_file);
  EXPECT_EQ(
      absl::StrReplaceAll(
          {{"<body name=\"leg_fl\"",
            absl::StrCat("<body name=\"leg_fl\" euler=\"0 ", pitch, " 0\"")},
           {"<joint name=\"hip_fl\"",
            absl::StrCat("<joint name=\"hip_fl\" ", hinge)}},
          &model),
      2);
  EXPECT_THAT(WriteFileAtomically(text_file, text), IsOk());
  EXPECT_THAT(WriteFileAtomically(model_file, model), IsOk());
  v1::Recipe recipe = testing::ToyRecipe();
  auto* observation = recipe.mutable_task()->mutable_observation();
  observation->clear_blocks();
  observation->add_blocks(block);
  const auto character =
      character::Character::Load(text_file, recipe.physics());
  if (!character.ok()) return character.status();
  testing::LibraryMaker maker(**character);
  const character::DataPtr data(mj_makeData((*character)->model()));
  mj_forward((*character)->model(), data.get());
  v1::ClipInfo clip;
  clip.set_name("still");
  maker.BeginClip(clip);
  for (int frame = 0; frame < 4; ++frame) maker.AddFrame(data.get(), true);
  const auto library = maker.Make(testing::NewFolder());
  const auto task = TrackingTask::Create(recipe, **character, *library);
  if (!task.ok()) return task.status();
  return MakeMirror(**task).status();
}

TEST(Mirror, NeedsFramesThatMirrorEachOtherWhereABlockShowsThem) {
  for (const auto block : {v1::Observation::BLOCK_REFERENCE_BODIES,
                           v1::Observation::BLOCK_SELF_BODIES}) {
    EXPECT_THAT(MirrorTable(/*pitch=*/0, block), IsOk());
    EXPECT_THAT(
        MirrorTable(/*pitch=*/0.5, block),
        StatusIs(absl::StatusCode::kFailedPrecondition,
                 HasSubstr(absl::StrCat(
                     "expected frames of leg_fl and leg_fr that mirror each "
                     "other at rest, which ",
                     v1::Observation::Block_Name(block), " needs"))));
  }
  EXPECT_THAT(
      MirrorTable(/*pitch=*/0.5, v1::Observation::BLOCK_SELF_JOINT_SPACE),
      IsOk());
}

TEST(Mirror, NeedsEqualRangesLeftAndRight) {
  EXPECT_THAT(MirrorTable(/*pitch=*/0, v1::Observation::BLOCK_SELF_JOINT_SPACE,
                          "range=\"-0.5 1\""),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("hip_fl and hip_fr to have equal ranges")));
}

TEST(Mirror, NeedsAPartnerForEveryJoint) {
  const testing::ToyWorld toy = testing::MakeToyWorld();
  const auto task =
      TrackingTask::Create(toy.recipe, *toy.character, *toy.library);
  ASSERT_TRUE(task.ok()) << task.status();

  EXPECT_THAT(MakeMirror(**task).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected a pair with joint hip_fl")));
}

}  // namespace
}  // namespace sinew::world
