#include "sim/import/testing/amc_play.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/motion/rotation.h"

namespace sinew::import::testing {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using ::sinew::testing::IsOk;

struct Recording {
  SourceClip clip;               // as our reader gives it
  std::vector<AmcFrame> frames;  // as it stands in the file
};

Recording Read(const std::string& asf_path, const std::string& amc_path) {
  const auto asf = ParseAsf(*ReadFile(asf_path), asf_path);
  EXPECT_THAT(asf, IsOk());
  auto clip = ParseAmc(*ReadFile(amc_path), *asf, "clip", amc_path, {});
  EXPECT_THAT(clip, IsOk());
  return {.clip = *std::move(clip), .frames = ReadAmc(amc_path)};
}

// The character in the pose of one frame.
class Player {
 public:
  Player() {
    auto loaded = character::Character::Load("cmu_humanoid", v1::Physics());
    EXPECT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
    data_.reset(mj_makeData(character_->model()));
    mj_kinematics(character_->model(), data_.get());
    for (int b = 0; b < character_->model()->nbody; ++b) {
      rest_.push_back(Rotation(b));
    }
  }

  const character::Character& character() const { return *character_; }

  void Set(const Eigen::VectorXd& qpos) {
    mju_copy(data_->qpos, qpos.data(), character_->model()->nq);
    mj_kinematics(character_->model(), data_.get());
  }
  Vector3d Place(const std::string& body) const {
    return Eigen::Map<const Vector3d>(data_->xpos + 3 * Id(body));
  }
  // World rotation since the rest pose.
  Quaterniond Turn(const std::string& body) const {
    return Rotation(Id(body)) * rest_[Id(body)].conjugate();
  }

 private:
  int Id(const std::string& body) const {
    return mj_name2id(character_->model(), mjOBJ_BODY, body.c_str());
  }
  Quaterniond Rotation(int body) const {
    return motion::FromWxyz(data_->xquat + 4 * body).normalized();
  }

  std::unique_ptr<character::Character> character_;
  character::DataPtr data_;
  std::vector<Quaterniond> rest_;
};

double LegLength(const SourceSkeleton& skeleton) {
  return skeleton.joints[skeleton.Find("ltibia")].offset.norm() +
         skeleton.joints[skeleton.Find("lfoot")].offset.norm();
}

class AmcPlayTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* data = std::getenv("SINEW_DATA");
    if (data == nullptr) {
      GTEST_SKIP() << "SINEW_DATA is not set: no recorded clips";
    }
    const std::string folder =
        JoinPath(data, "motions/cmu_amc/" + std::string(GetParam(), 2));
    recording_ = Read(JoinPath(folder, std::string(GetParam(), 2) + ".asf"),
                      JoinPath(folder, std::string(GetParam()) + ".amc"));
    ASSERT_EQ(recording_.frames.size(), recording_.clip.poses.size());
  }

  Recording recording_;
  Player player_;
};

// Signs, axes and order of every angle: bones turn as our reader says.
TEST_P(AmcPlayTest, TurnsEveryBoneAsTheReaderDoes) {
  const SourceSkeleton& skeleton = recording_.clip.skeleton;
  const ModelMotion motion =
      PlayAmc(player_.character(), recording_.frames, /*metres_per_unit=*/1);

  for (int t = 0; t < motion.frames(); t += 25) {
    player_.Set(motion.qpos[t]);
    const std::vector<Quaterniond> world =
        WorldRotations(skeleton, recording_.clip.poses[t].rotation);
    for (const char* bone :
         {"root",      "lowerback", "upperback", "thorax", "lowerneck",
          "upperneck", "head",      "lfemur",    "ltibia", "lfoot",
          "ltoes",     "rfemur",    "rtibia",    "rfoot",  "rtoes",
          "lclavicle", "lhumerus",  "lradius",   "lwrist", "lhand",
          "rclavicle", "rhumerus",  "rradius",   "rwrist", "rhand"}) {
      EXPECT_LT(
          motion::AngleBetween(player_.Turn(bone), world[skeleton.Find(bone)]),
          0.01)
          << bone << " in frame " << t;
    }
  }
}

// All that is left are people's proportions: the model is one body, with arms
// and a trunk of its own, whatever the length of its legs. Measured, mean over
// feet, hands and head: 07_01 24 mm, 02_03 36, 16_11 46, 35_01 57; feet alone 8
// to 40 mm.
TEST_P(AmcPlayTest, KeepsEndEffectorsNearTheSkeletonsOfTheSameLegLength) {
  const SourceSkeleton& skeleton = recording_.clip.skeleton;
  const ModelMotion motion =
      PlayAmc(player_.character(), recording_.frames, /*metres_per_unit=*/1);
  player_.Set(motion.qpos[0]);
  const double legs =
      (player_.Place("ltibia") - player_.Place("lfemur")).norm() +
      (player_.Place("lfoot") - player_.Place("ltibia")).norm();
  const double scale = legs / LegLength(skeleton);

  std::map<std::string, double> sum;
  double mean = 0;
  int frames = 0;
  for (int t = 0; t < motion.frames(); t += 5, ++frames) {
    player_.Set(motion.qpos[t]);
    const SourcePose& pose = recording_.clip.poses[t];
    const std::vector<Vector3d> places =
        WorldPositions(skeleton, pose.root_position, pose.rotation);
    for (const char* body : {"lfoot", "rfoot", "lhand", "rhand", "head"}) {
      const Vector3d source = scale * (places[skeleton.Find(body)] - places[0]);
      const Vector3d played = player_.Place(body) - player_.Place("root");
      sum[body] += (source - played).norm();
    }
  }
  for (const auto& [body, distance] : sum) {
    RecordProperty(body, std::to_string(distance / frames));
    mean += distance / frames / static_cast<double>(sum.size());
  }
  EXPECT_LT(mean, 0.06);
  EXPECT_LT(sum["lfoot"] / frames, 0.045);
  EXPECT_LT(sum["rfoot"] / frames, 0.045);
}

INSTANTIATE_TEST_SUITE_P(Clips, AmcPlayTest,
                         ::testing::Values("02_03", "07_01", "16_11", "35_01"));

}  // namespace
}  // namespace sinew::import::testing
