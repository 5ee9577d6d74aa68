#include "sim/world/observation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/world/testing/random_state.h"

namespace sinew::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Moved;
using testing::RandomState;
using Observation = v1::Observation;

constexpr int kBodies = 3;
constexpr int kJoints = 2;
constexpr int kFeet = 2;
constexpr int kSelf = 13 + 2 * kJoints + 3 * (kBodies - 1);
constexpr int kDifference = kSelf + 2;
constexpr int kSelfBodies = 1 + 3 * (kBodies - 1) + (6 + 3 + 3) * kBodies;

// Everything at hand for one observation of random states.
struct Scene {
  explicit Scene(int frames) : body(RandomState(1, kBodies, kJoints)) {
    for (int i = 0; i < frames; ++i) {
      reference.push_back(RandomState(2 + i, kBodies, kJoints));
    }
    for (int i = 0; i < frames; ++i) contacts.push_back(labels);
  }
  std::vector<float> Observe(const ObservationBuilder& builder) const {
    std::vector<float> out(builder.width());
    builder.Build({.body = &body,
                   .reference = reference,
                   .reference_contact = contacts,
                   .previous_target = target,
                   .self_contact = touching},
                  absl::MakeSpan(out));
    return out;
  }

  BodyState body;
  std::vector<BodyState> reference;
  const float labels[kFeet] = {1, 0};
  std::vector<const float*> contacts;
  std::vector<double> target = {0.5, -0.5};
  std::vector<float> touching = {0, 1};
};

ObservationBuilder Builder(std::vector<Observation::Block> blocks,
                           std::vector<int> ahead = {1}) {
  Observation recipe;
  for (auto block : blocks) recipe.add_blocks(block);
  for (int frame : ahead) recipe.add_frames_ahead(frame);
  auto builder = ObservationBuilder::Create(recipe, kBodies, kJoints, kFeet);
  EXPECT_TRUE(builder.ok()) << builder.status();
  return *builder;
}

// Rotation by the heading, worked out from the matrix: the swing-twist
// decomposition's twist angle is atan2(R10 - R01, R00 + R11).
Matrix3d HeadingMatrix(const Quaterniond& rotation) {
  const Matrix3d r = rotation.toRotationMatrix();
  const double yaw = std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
  Matrix3d h = Matrix3d::Identity();
  h(0, 0) = h(1, 1) = std::cos(yaw);
  h(1, 0) = std::sin(yaw);
  h(0, 1) = -std::sin(yaw);
  return h;
}

void ExpectVector(const std::vector<float>& out, int& at,
                  const Vector3d& expected, const char* what) {
  for (int i = 0; i < 3; ++i, ++at) {
    EXPECT_NEAR(out[at], expected[i], 1e-6) << what << " axis " << i;
  }
}

void ExpectSixD(const std::vector<float>& out, int& at,
                const Matrix3d& expected) {
  ExpectVector(out, at, expected.col(0), "first column");
  ExpectVector(out, at, expected.col(1), "second column");
}

TEST(Observation, SelfBlockAgreesWithRotationMatrices) {
  const Scene scene(1);
  const auto out =
      scene.Observe(Builder({Observation::BLOCK_SELF_JOINT_SPACE}));
  const BodyState& body = scene.body;
  const Matrix3d inverse = HeadingMatrix(body.rotation[0]).transpose();

  ASSERT_EQ(out.size(), kSelf);
  EXPECT_NEAR(out[0], body.position[0].z(), 1e-6);
  int at = 1;
  ExpectSixD(out, at, inverse * body.rotation[0].toRotationMatrix());
  ExpectVector(out, at, inverse * body.linear_velocity[0], "velocity");
  ExpectVector(out, at, inverse * body.angular_velocity[0], "rate");
  for (double q : body.joint_position) EXPECT_NEAR(out[at++], q, 1e-6);
  for (double dq : body.joint_velocity) EXPECT_NEAR(out[at++], dq, 1e-6);
  for (int b = 1; b < kBodies; ++b) {
    ExpectVector(out, at, inverse * (body.position[b] - body.position[0]),
                 "body");
  }
  EXPECT_EQ(at, kSelf);
}

TEST(Observation, SelfBodiesAgreeWithRotationMatrices) {
  const Scene scene(1);
  const auto out = scene.Observe(Builder({Observation::BLOCK_SELF_BODIES}));
  const BodyState& body = scene.body;
  const Matrix3d inverse = HeadingMatrix(body.rotation[0]).transpose();

  ASSERT_EQ(out.size(), kSelfBodies);
  EXPECT_NEAR(out[0], body.position[0].z(), 1e-6);
  int at = 1;
  for (int b = 1; b < kBodies; ++b) {
    ExpectVector(out, at, inverse * (body.position[b] - body.position[0]),
                 "position");
  }
  for (const Quaterniond& rotation : body.rotation) {
    ExpectSixD(out, at, inverse * rotation.toRotationMatrix());
  }
  for (const Vector3d& velocity : body.linear_velocity) {
    ExpectVector(out, at, inverse * velocity, "velocity");
  }
  for (const Vector3d& rate : body.angular_velocity) {
    ExpectVector(out, at, inverse * rate, "rate");
  }
  EXPECT_EQ(at, kSelfBodies);
}

TEST(Observation, SelfBodiesOf24BodiesAre358Numbers) {
  Observation recipe;
  recipe.add_blocks(Observation::BLOCK_SELF_BODIES);
  const auto builder = ObservationBuilder::Create(recipe, /*bodies=*/24,
                                                  /*joints=*/69, /*feet=*/2);

  ASSERT_TRUE(builder.ok()) << builder.status();
  EXPECT_EQ(builder->width(), 358);
  EXPECT_EQ(builder->self_width(), 358);
}

TEST(Observation, DifferenceBlockAgreesWithRotationMatrices) {
  const Scene scene(2);
  const auto out =
      scene.Observe(Builder({Observation::BLOCK_REFERENCE_DIFFERENCE}, {1, 4}));
  const BodyState& body = scene.body;
  const Matrix3d h = HeadingMatrix(body.rotation[0]);

  ASSERT_EQ(out.size(), 2 * kDifference);
  int at = 0;
  for (const BodyState& hat : scene.reference) {
    const Matrix3d turn = hat.rotation[0].toRotationMatrix() *
                          body.rotation[0].toRotationMatrix().transpose();
    ExpectVector(out, at, h.transpose() * (hat.position[0] - body.position[0]),
                 "root");
    ExpectSixD(out, at, h.transpose() * turn * h);
    ExpectVector(
        out, at,
        h.transpose() * (hat.linear_velocity[0] - body.linear_velocity[0]),
        "velocity");
    ExpectVector(
        out, at,
        h.transpose() * (hat.angular_velocity[0] - body.angular_velocity[0]),
        "rate");
    for (int j = 0; j < kJoints; ++j) {
      EXPECT_NEAR(out[at++], hat.joint_position[j] - body.joint_position[j],
                  1e-6);
    }
    for (int j = 0; j < kJoints; ++j) {
      EXPECT_NEAR(out[at++], hat.joint_velocity[j] - body.joint_velocity[j],
                  1e-6);
    }
    for (int b = 1; b < kBodies; ++b) {
      const Vector3d mine = body.position[b] - body.position[0];
      const Vector3d its = hat.position[b] - hat.position[0];
      ExpectVector(out, at, h.transpose() * (its - mine), "body");
    }
  }
  EXPECT_EQ(at, 2 * kDifference);
}

TEST(Observation, DifferencesVanishOnTheReference) {
  Scene scene(1);
  scene.reference[0] = scene.body;
  const auto out =
      scene.Observe(Builder({Observation::BLOCK_REFERENCE_DIFFERENCE}));

  for (int i = 0; i < kDifference; ++i) {
    // The rotation's 6D is that of the identity: 1 0 0 0 1 0.
    const float expected = i == 3 || i == 7 ? 1 : 0;
    EXPECT_NEAR(out[i], expected, 1e-6) << i;
  }
}

TEST(Observation, OtherBlocksAreCopiesAndDifferences) {
  const Scene scene(2);
  const auto out = scene.Observe(Builder(
      {Observation::BLOCK_SELF_CONTACT, Observation::BLOCK_PREVIOUS_TARGET,
       Observation::BLOCK_REFERENCE_CONTACT},
      {1, 2}));

  EXPECT_THAT(
      out, ElementsAre(0, 1, float(0.5 - scene.body.joint_position[0]),
                       float(-0.5 - scene.body.joint_position[1]), 1, 0, 1, 0));
}

TEST(Observation, DoesNotDependOnWhereTheWorldsOriginIsOrWhichWayItFaces) {
  const ObservationBuilder builder = Builder(
      {Observation::BLOCK_SELF_JOINT_SPACE, Observation::BLOCK_SELF_BODIES,
       Observation::BLOCK_REFERENCE_DIFFERENCE});
  const Scene scene(1);
  Scene moved = scene;
  moved.contacts = {moved.labels};
  const Vector3d offset(40, -7, 0);  // along the floor: height is observed
  moved.body = Moved(scene.body, 2.2, offset);
  moved.reference[0] = Moved(scene.reference[0], 2.2, offset);

  const auto expected = scene.Observe(builder);
  const auto out = moved.Observe(builder);

  for (size_t i = 0; i < out.size(); ++i) {
    EXPECT_NEAR(out[i], expected[i], 1e-5) << i;
  }
}

TEST(Observation, SeesEveryPartOfAReference) {
  const ObservationBuilder builder =
      Builder({Observation::BLOCK_REFERENCE_DIFFERENCE});
  Scene scene(1);
  const auto before = scene.Observe(builder);
  scene.reference[0].position[2].x() += 1;

  EXPECT_NE(scene.Observe(builder), before);
}

TEST(Observation, NamesEveryColumn) {
  const ObservationBuilder builder = Builder(
      {Observation::BLOCK_SELF_JOINT_SPACE,
       Observation::BLOCK_REFERENCE_DIFFERENCE,
       Observation::BLOCK_PREVIOUS_TARGET, Observation::BLOCK_REFERENCE_CONTACT,
       Observation::BLOCK_SELF_CONTACT, Observation::BLOCK_SELF_BODIES},
      {1, 3});
  const auto names = builder.Names({.joints = {"knee", "hip"},
                                    .bodies = {"pelvis", "head", "hand"},
                                    .feet = {"left", "right"}});

  ASSERT_EQ(static_cast<int>(names.size()), builder.width());
  EXPECT_EQ(names[0], "self/root_height");
  EXPECT_EQ(names[13], "self/joint_position/knee");
  EXPECT_EQ(names[kSelf], "reference+1/root_position/x");
  EXPECT_EQ(names[kSelf + 2 * kDifference], "previous_target/knee");
  const int bodies = builder.width() - kSelfBodies;
  EXPECT_EQ(names[bodies - 1], "self/contact/right");
  EXPECT_EQ(names[bodies], "self_body/root_height");
  EXPECT_EQ(names[bodies + 1], "self_body/position/head/x");
  EXPECT_EQ(names[bodies + 7], "self_body/rotation/pelvis/00");
  EXPECT_EQ(names[bodies + 25], "self_body/linear_velocity/pelvis/x");
  EXPECT_EQ(names[bodies + 39], "self_body/angular_velocity/head/z");
  EXPECT_EQ(names.back(), "self_body/angular_velocity/hand/z");
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(),
            names.size());
}

TEST(Observation, HasTwoBlocksAndOneFrameByDefault) {
  const auto builder =
      ObservationBuilder::Create(Observation(), /*bodies=*/15, /*joints=*/28,
                                 /*feet=*/2);

  ASSERT_TRUE(builder.ok());
  EXPECT_EQ(builder->width(), 111 + 113);
}

TEST(Observation, FindsTheColumnsOfAnObservationOfLess) {
  const Scene scene(2);
  const ObservationBuilder whole = Builder(
      {Observation::BLOCK_SELF_JOINT_SPACE, Observation::BLOCK_PREVIOUS_TARGET,
       Observation::BLOCK_REFERENCE_DIFFERENCE,
       Observation::BLOCK_REFERENCE_CONTACT},
      {1, 3});
  const auto part = whole.ForSameCharacter([] {
    Observation recipe;
    recipe.add_blocks(Observation::BLOCK_REFERENCE_CONTACT);
    recipe.add_blocks(Observation::BLOCK_REFERENCE_DIFFERENCE);
    recipe.add_blocks(Observation::BLOCK_SELF_JOINT_SPACE);
    recipe.add_frames_ahead(3);
    return recipe;
  }());
  ASSERT_TRUE(part.ok());

  const auto columns = whole.ColumnsOf(*part);

  ASSERT_TRUE(columns.has_value());
  ASSERT_EQ(static_cast<int>(columns->size()), part->width());
  const std::vector<float> all = scene.Observe(whole);
  Scene later(1);  // the second of its frames
  later.reference = {scene.reference[1]};
  const std::vector<float> seen = later.Observe(*part);
  for (size_t i = 0; i < columns->size(); ++i) {
    EXPECT_EQ(seen[i], all[(*columns)[i]]) << i;
  }
  EXPECT_FALSE(part->ColumnsOf(whole).has_value());
}

// A recipe may name one twice; what comes after it is no other column.
TEST(Observation, FindsTheColumnsBehindAFrameThatIsThereTwice) {
  const ObservationBuilder whole =
      Builder({Observation::BLOCK_REFERENCE_DIFFERENCE,
               Observation::BLOCK_SELF_JOINT_SPACE},
              {1, 1});
  const auto columns =
      whole.ColumnsOf(Builder({Observation::BLOCK_SELF_JOINT_SPACE}));

  ASSERT_TRUE(columns.has_value());
  EXPECT_EQ(columns->front(), 2 * kDifference);
  EXPECT_EQ(columns->back(), whole.width() - 1);
}

TEST(Observation, SelfPartIsItsFirstColumnsBitForBit) {
  const Scene scene(2);
  const ObservationBuilder builder = Builder(
      {Observation::BLOCK_SELF_JOINT_SPACE, Observation::BLOCK_SELF_CONTACT,
       Observation::BLOCK_PREVIOUS_TARGET,
       Observation::BLOCK_REFERENCE_DIFFERENCE},
      {1, 2});

  const ObservationBuilder part = builder.SelfPart();

  ASSERT_EQ(part.width(), builder.self_width());
  EXPECT_FALSE(part.Has(Observation::BLOCK_REFERENCE_DIFFERENCE));
  std::vector<float> own(part.width());
  part.Build({.body = &scene.body,
              .reference = {},
              .reference_contact = {},
              .previous_target = scene.target,
              .self_contact = scene.touching},
             absl::MakeSpan(own));
  std::vector<float> first = scene.Observe(builder);
  first.resize(own.size());
  EXPECT_EQ(own, first);
}

TEST(Observation, RefusesUnknownAndRepeatedBlocksAndTheCurrentFrame) {
  const auto create = [](std::vector<int> blocks, std::vector<int> ahead) {
    Observation recipe;
    for (int block : blocks) {
      recipe.add_blocks(static_cast<Observation::Block>(block));
    }
    for (int frame : ahead) recipe.add_frames_ahead(frame);
    return ObservationBuilder::Create(recipe, 3, 2, 2).status();
  };
  const auto refused = [](const char* message) {
    return StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };

  EXPECT_THAT(create({0}, {}),
              refused("task.observation.blocks[0]: expected a known block"));
  EXPECT_THAT(create({1, 2, 1}, {}),
              refused("blocks[2]: expected each block once, found "
                      "BLOCK_SELF_JOINT_SPACE again"));
  EXPECT_THAT(create({1}, {1, 0}),
              refused("frames_ahead[1]: expected >= 1, found 0"));
}

TEST(Observation, KnowsTheColumnsThatNeedNoReference) {
  EXPECT_EQ(Builder({}).self_width(), kSelf);
  EXPECT_EQ(Builder({Observation::BLOCK_SELF_CONTACT,
                     Observation::BLOCK_SELF_JOINT_SPACE,
                     Observation::BLOCK_PREVIOUS_TARGET,
                     Observation::BLOCK_REFERENCE_DIFFERENCE})
                .self_width(),
            kFeet + kSelf + kJoints);
  EXPECT_EQ(Builder({Observation::BLOCK_SELF_BODIES,
                     Observation::BLOCK_REFERENCE_BODIES})
                .self_width(),
            kSelfBodies);
  // What comes after a goal does not count.
  EXPECT_EQ(Builder({Observation::BLOCK_REFERENCE_DIFFERENCE,
                     Observation::BLOCK_SELF_CONTACT})
                .self_width(),
            0);
}

}  // namespace
}  // namespace sinew::world
