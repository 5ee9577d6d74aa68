// Every skeleton map that comes with the project, from joints of its names to
// the humanoid, and a recording of each dialect that there is one of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/bvh.h"
#include "sim/import/formats/testing/made_files.h"
#include "sim/import/import_clip.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/quality_gate.h"
#include "sim/import/read_clip.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/testing/humanoid_fixture.h"
#include "sim/import/testing/made_skeletons.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using ::sinew::testing::IsOk;

// Names of maps whose dialect's rest pose does not stand, so that names alone
// make no skeleton of it.
const char* const kLyingDialects[] = {"lafan1", "rokoko"};

// A made person's clip with a map's names: what the map has and the person has
// not is an end of the limb that it belongs to.
SourceClip Spoken(const v1::SkeletonMap& map) {
  SourceClip clip = testing::MadeClip({});
  const auto draft = DraftSkeletonMap(clip.skeleton, "draft");
  EXPECT_THAT(draft, IsOk());
  std::map<std::string, int> joint_of_role;
  for (const v1::JointRole& joint : draft->joints()) {
    joint_of_role[joint.role()] = clip.skeleton.Find(joint.source());
  }
  for (const v1::JointRole& joint : map.joints()) {
    const auto found = joint_of_role.find(joint.role());
    if (found != joint_of_role.end()) {
      clip.skeleton.joints[found->second].name = joint.source();
      continue;
    }
    const std::string side = joint.role().substr(0, joint.role().find('_') + 1);
    const auto hand = joint_of_role.find(absl::StrCat(side, "wrist"));
    EXPECT_NE(hand, joint_of_role.end()) << joint.role();
    if (hand == joint_of_role.end()) continue;
    clip.skeleton.joints.push_back(
        {joint.source(), hand->second, Vector3d(0, 0, -0.08)});
    for (SourcePose& pose : clip.poses) {
      pose.rotation.push_back(Eigen::Quaterniond::Identity());
    }
  }
  return clip;
}

class EveryDialectTest : public testing::HumanoidFixture {
 protected:
  void ExpectGood(const Source& source, const std::string& map) {
    const auto clip = ImportClip(model_, source, {});
    ASSERT_THAT(clip, IsOk()) << map;
    EXPECT_EQ(clip->info.source().map(), map);
    const Verdict verdict = JudgeQuality(clip->info.quality());
    EXPECT_NE(verdict.status, ClipStatus::kRejected)
        << map << ": " << verdict.reason;
    EXPECT_LT(clip->info.quality().retarget_error_m(), 0.08) << map;
  }
};

TEST_F(EveryDialectTest, IsKnownByItsNamesAndRetargeted) {
  const auto maps = KnownSkeletonMaps();
  ASSERT_THAT(maps, IsOk());
  ASSERT_GE(maps->size(), 14u);
  for (const v1::SkeletonMap& map : *maps) {
    if (std::count(std::begin(kLyingDialects), std::end(kLyingDialects),
                   map.name()) > 0) {
      continue;
    }
    ExpectGood(Spoken(map), map.name());
  }
}

// Stands with hanging arms and flat feet, as the dialect's angles say it.
TEST_F(EveryDialectTest, Lafan1StandsAndLooksWhereItsToesPoint) {
  const auto source =
      ParseBvh(testing::MadeLafanBvh(60), "stand", "stand.bvh", {});
  ASSERT_THAT(source, IsOk());
  ExpectGood(*source, "lafan1");

  const auto played = RetargetClip(model_, *source, {});
  ASSERT_THAT(played, IsOk());
  dynamics_->SetPose(played->motion.qpos[30]);
  const mjModel& model = *model_.model;
  const auto body = [&](const char* name) {
    return mj_name2id(&model, mjOBJ_BODY, name);
  };
  const auto place = [&](const char* name) {
    return Vector3d(dynamics_->data().xpos + 3 * body(name));
  };
  EXPECT_GT(place("head").z(), 1.2);
  EXPECT_LT(place("left_foot").z(), 0.15);
  // Its left is the file's z, which becomes x; it looks along the file's -x.
  const Vector3d across = place("left_thigh") - place("right_thigh");
  EXPECT_GT(across.normalized().x(), 0.95);
  const double* axes = dynamics_->data().xmat + 9 * body("pelvis");
  EXPECT_LT(axes[3], -0.95) << "y of where the pelvis looks";
  // No joint is anywhere near a limit: knees and elbows are straight, and
  // nothing was turned about to get there.
  for (const ImportJoint& joint : model_.joints) {
    EXPECT_LT(std::abs(played->motion.qpos[30][joint.qpos_address]), 0.6)
        << mj_id2name(&model, mjOBJ_JOINT, model.dof_jntid[joint.dof_address]);
  }
}

TEST_F(EveryDialectTest, TakesARecordingOfEachThatThereIsOneOf) {
  const char* data = std::getenv("SINEW_DATA");
  if (data == nullptr) GTEST_SKIP() << "SINEW_DATA is not set";
  const std::pair<const char*, const char*> recordings[] = {
      {"animated_drawings", "animated_drawings_bvh/wave_hello.bvh"},
      {"cmu_asf", "cmu_amc/01/01_01.amc"},
      {"cmu_bvh", "cmu_bvh/02/02_01.bvh"},
      {"cmu_bvh_max", "animated_drawings_bvh/jumping_jacks.bvh"},
      {"makehuman", "makehuman_bvh/walk1.bvh"},
      {"mass_bvh", "mass_bvh/walk.bvh"},
      {"react_idle", "react_idle/010_acted.bvh"},
      {"rokoko", "animated_drawings_bvh/jesse_dance.bvh"},
      {"smpl", "asap/smpl_npz/video_walk_level1_filter_amass.npz"},
  };
  for (const auto& [map, file] : recordings) {
    const std::string path = absl::StrCat(data, "/motions/", file);
    const auto bytes = ReadFile(path);
    ASSERT_THAT(bytes, IsOk());
    const auto source = ReadClip(path, *bytes, "clip", &model_, {});
    ASSERT_THAT(source, IsOk()) << file;
    ExpectGood(*source, map);
  }
}

}  // namespace
}  // namespace sinew::import
