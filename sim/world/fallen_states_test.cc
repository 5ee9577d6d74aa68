#include "sim/world/fallen_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

class FallenStatesTest : public ::testing::Test {
 protected:
  FallenStates Make(int count, uint64_t seed) const {
    auto made = FallenStates::Make(*toy_.character, toy_.recipe, count, seed);
    EXPECT_TRUE(made.ok()) << made.status();
    return *std::move(made);
  }
  absl::Status Parse(const std::string& bytes) const {
    return FallenStates::Parse(bytes, *toy_.character, "file").status();
  }
  // Metres above the floor: no part of the body is lower.
  double LowestPoint(mjData* data) const {
    const mjModel* model = toy_.character->model();
    mj_kinematics(model, data);
    double lowest = std::numeric_limits<double>::infinity();
    for (int geom = 0; geom < model->ngeom; ++geom) {
      if (model->geom_bodyid[geom] == 0) continue;  // the floor
      lowest = std::min(
          lowest, data->geom_xpos[3 * geom + 2] - model->geom_rbound[geom]);
    }
    return lowest;
  }
  // A file with these positions and metadata.
  static std::string File(int64_t rows, const std::vector<double>& qpos,
                          const std::string& character,
                          const std::string& version = "1") {
    return SerializeSafetensors(
        {{"qpos", HostTensor::Float64(
                      {rows, static_cast<int64_t>(qpos.size()) / rows}, qpos)}},
        {{"format", "sinew.fallen_states"},
         {"format_version", version},
         {"character_sha256", character}});
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
};

TEST_F(FallenStatesTest, LieOnTheFloorInPosesOfTheirOwn) {
  const FallenStates states = Make(6, 1);
  const mjModel* model = toy_.character->model();
  const character::DataPtr data(mj_makeData(model));

  ASSERT_EQ(states.size(), 6);
  bool tilted = false;
  for (int i = 0; i < 6; ++i) {
    const absl::Span<const double> qpos = states.qpos(i);
    // Positions alone: a free joint and four hinges.
    ASSERT_EQ(qpos.size(), 11);
    for (double number : qpos) EXPECT_TRUE(std::isfinite(number)) << i;
    EXPECT_EQ(qpos[0], 0);
    EXPECT_EQ(qpos[1], 0);
    EXPECT_NEAR(mju_norm(qpos.data() + 3, 4), 1, 1e-12);
    std::copy(qpos.begin(), qpos.end(), data->qpos);
    EXPECT_LT(LowestPoint(data.get()), 0.5) << i;  // random targets make it hop
    double up[3];
    const double z[3] = {0, 0, 1};
    mju_rotVecQuat(up, z, qpos.data() + 3);
    tilted = tilted || up[2] < 0.9;
  }
  EXPECT_TRUE(tilted);
  EXPECT_THAT(states.qpos(0), ::testing::Not(ElementsAreArray(states.qpos(1))));
}

TEST_F(FallenStatesTest, AreTheSameForTheSameSeedAndEachDependsOnItsIndexOnly) {
  const FallenStates four = Make(4, 1);

  EXPECT_EQ(Make(4, 1).Serialize(), four.Serialize());
  EXPECT_THAT(Make(2, 1).qpos(1), ElementsAreArray(four.qpos(1)));
  EXPECT_THAT(Make(1, 2).qpos(0),
              ::testing::Not(ElementsAreArray(four.qpos(0))));
}

TEST_F(FallenStatesTest, OfEvaluationsAreThoseOfNoRecipe) {
  const auto evaluation =
      FallenStates::MakeForEvaluation(*toy_.character, toy_.recipe, 2);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const auto again =
      FallenStates::MakeForEvaluation(*toy_.character, toy_.recipe, 1);
  ASSERT_TRUE(again.ok()) << again.status();

  EXPECT_THAT(again->qpos(0), ElementsAreArray(evaluation->qpos(0)));
  // Nor of one with this very seed.
  const FallenStates trained_on = Make(2, FallenStates::kEvaluationSeed);
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(evaluation->qpos(i),
                ::testing::Not(ElementsAreArray(trained_on.qpos(i))));
  }
}

TEST_F(FallenStatesTest, SurviveWritingAndReading) {
  const FallenStates states = Make(3, 1);
  const auto read =
      FallenStates::Parse(states.Serialize(), *toy_.character, "file");

  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 3);
  EXPECT_THAT(read->qpos(2), ElementsAreArray(states.qpos(2)));
  EXPECT_EQ(read->Serialize(), states.Serialize());
}

TEST_F(FallenStatesTest, RefuseWhatIsNotOfThisCharacterOrVersion) {
  const std::vector<double> qpos = {0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0};
  const std::string digest = toy_.character->digest();
  ASSERT_TRUE(Parse(File(1, qpos, digest)).ok());

  EXPECT_THAT(Parse(File(1, qpos, "other")),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "file: fallen states: character_sha256: expected " +
                           digest + ", found other"));
  EXPECT_THAT(Parse(File(1, qpos, digest, "2")),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("format_version: expected 1, found 2")));
  EXPECT_THAT(Parse("nonsense"), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(FallenStatesTest, RefusePositionsThatAreNone) {
  const std::string digest = toy_.character->digest();
  std::vector<double> qpos = {0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0};

  EXPECT_THAT(Parse(File(1, std::vector<double>(10), digest)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected float64 [N >= 1, 11]")));
  qpos[3] = 0.5;
  EXPECT_THAT(Parse(File(1, qpos, digest)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("qpos[0]: expected a unit quaternion")));
  qpos[8] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(Parse(File(1, qpos, digest)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("qpos[0, 8]: expected a finite number")));
}

TEST_F(FallenStatesTest, AreAtLeastOne) {
  EXPECT_THAT(FallenStates::Make(*toy_.character, toy_.recipe, 0, 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("count: expected >= 1, found 0")));
}

}  // namespace
}  // namespace sinew::world
