#include "sim/import/maps/skeleton_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/deepmimic.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/testing/made_skeletons.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr char kLegs[] = R"pb(
  name: "legs"
  joints { source: "Hips" role: "root" }
  joints { source: "LeftUpLeg" role: "left_hip" }
  joints { source: "LeftLeg" role: "left_knee" }
  joints { source: "LeftFoot" role: "left_ankle" }
  joints { source: "RightUpLeg" role: "right_hip" }
  joints { source: "RightLeg" role: "right_knee" }
  joints { source: "RightFoot" role: "right_ankle" }
)pb";

std::string With(const std::string& from, const std::string& to) {
  return absl::StrReplaceAll(kLegs, {{from, to}});
}

auto Refused(const std::string& message) {
  return StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message));
}

std::string RoleOf(const v1::SkeletonMap& map, const std::string& source) {
  for (const v1::JointRole& joint : map.joints()) {
    if (joint.source() == source) return joint.role();
  }
  return "";
}

TEST(SkeletonMapsTest, AMapThatLacksOrRepeatsOrInventsIsRefusedByName) {
  EXPECT_THAT(ParseSkeletonMap(kLegs, "legs.textproto"), IsOk());
  EXPECT_THAT(ParseSkeletonMap("joints {", "cut.textproto"),
              Refused("cut.textproto:"));
  EXPECT_THAT(ParseSkeletonMap(With("\"legs\"", "\"My Legs\""), "f"),
              Refused("f: name: expected [a-z0-9_]+, found \"My Legs\""));
  EXPECT_THAT(ParseSkeletonMap(With("left_knee", "left_nee"), "f"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("joint \"LeftLeg\""),
                             HasSubstr("found \"left_nee\""))));
  EXPECT_THAT(ParseSkeletonMap(With("right_knee", "left_knee"), "f"),
              Refused("expected each role once, found \"left_knee\" twice"));
  EXPECT_THAT(ParseSkeletonMap(With("RightLeg", "LeftLeg"), "f"),
              Refused("expected each joint once, found \"LeftLeg\" twice"));
  EXPECT_THAT(ParseSkeletonMap(With("right_knee", "head"), "f"),
              Refused("found none for right_knee"));
  EXPECT_THAT(
      ParseSkeletonMap(With("role: \"root\"", "role: \"root\" rest_degrees: 3"),
                       "f"),
      Refused("rest_degrees: expected three finite numbers or none, found 3"));
}

TEST(SkeletonMapsTest, AnUnknownJointIsNamedWithItsNearMisses) {
  const SourceSkeleton skeleton = testing::MadeClip({}).skeleton;
  const auto map = ParseSkeletonMap(With("\"LeftFoot\"", "\"LeftFeet\""), "f");
  ASSERT_THAT(map, IsOk());
  EXPECT_THAT(CheckMapFits(*map, skeleton),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("map legs: expected a joint "
                                       "\"LeftFeet\" (left_ankle)"),
                             HasSubstr("nearest: LeftFoot"))));
}

TEST(SkeletonMapsTest, LimbsThatDoNotHangTogetherAreRefused) {
  const SourceSkeleton skeleton = testing::MadeClip({}).skeleton;
  const auto map = ParseSkeletonMap(With("\"LeftLeg\" role: \"left_knee\"",
                                         "\"LeftLoArm\" role: \"left_knee\""),
                                    "f");
  ASSERT_THAT(map, IsOk());
  EXPECT_THAT(CheckMapFits(*map, skeleton),
              Refused("expected joint \"LeftLoArm\" (left_knee) below "
                      "\"LeftUpLeg\" (left_hip)"));
}

TEST(SkeletonMapsTest, NamesAreFoundBehindTheirNameSpace) {
  SourceSkeleton skeleton = testing::MadeClip({}).skeleton;
  for (SourceJoint& joint : skeleton.joints) {
    joint.name = absl::StrCat("mixamorig:", joint.name);
  }
  EXPECT_THAT(CheckMapFits(*ParseSkeletonMap(kLegs, "f"), skeleton), IsOk());
  EXPECT_EQ(FindMapped(skeleton, "Nose"), -1);
}

TEST(SkeletonMapsTest, TheMapsThatComeWithUsAreGoodAndTheirNamesTheirFiles) {
  const auto maps = KnownSkeletonMaps();
  ASSERT_THAT(maps, IsOk());
  EXPECT_GE(maps->size(), 12U);
  std::set<std::string> names;
  for (const v1::SkeletonMap& map : *maps) {
    EXPECT_TRUE(names.insert(map.name()).second) << map.name();
    const auto again = LoadSkeletonMap(map.name());
    ASSERT_THAT(again, IsOk());
    EXPECT_EQ(again->name(), map.name());
    EXPECT_FALSE(map.description().empty()) << map.name();
  }
  const v1::SkeletonMap* found = FindMapFor(*maps, DeepMimicSkeleton());
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->name(), "deepmimic");
  EXPECT_EQ(FindMapFor(*maps, testing::MadeClip({}).skeleton), nullptr);
}

TEST(SkeletonMapsTest, AnUnknownMapSaysWhereItWasLookedFor) {
  EXPECT_THAT(LoadSkeletonMap("no_such_map"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("looked in")));
}

TEST(SkeletonMapsTest, ADraftFindsEveryRoleFromNamesAndLengths) {
  for (const bool behind : {false, true}) {
    testing::SkeletonStyle style;
    style.side_behind = behind;
    style.arms = 1.2;
    style.extra_spine = 2;
    const SourceSkeleton skeleton = testing::MadeClip(style).skeleton;
    const auto map = DraftSkeletonMap(skeleton, "draft");
    ASSERT_THAT(map, IsOk());
    const auto left = [behind](const std::string& part) {
      return behind ? part + "_L" : "Left" + part;
    };
    EXPECT_EQ(RoleOf(*map, "Hips"), "root");
    EXPECT_EQ(RoleOf(*map, "Spine"), "spine");
    EXPECT_EQ(RoleOf(*map, "Chest"), "chest");
    EXPECT_EQ(RoleOf(*map, "Neck"), "neck");
    EXPECT_EQ(RoleOf(*map, "Head"), "head");
    EXPECT_EQ(RoleOf(*map, left("UpLeg")), "left_hip");
    EXPECT_EQ(RoleOf(*map, left("Leg")), "left_knee");
    EXPECT_EQ(RoleOf(*map, left("Foot")), "left_ankle");
    EXPECT_EQ(RoleOf(*map, left("Toe")), "left_toe");
    EXPECT_EQ(RoleOf(*map, left("Collar")), "left_clavicle");
    EXPECT_EQ(RoleOf(*map, left("UpArm")), "left_shoulder");
    EXPECT_EQ(RoleOf(*map, left("LoArm")), "left_elbow");
    EXPECT_EQ(RoleOf(*map, left("Hand")), "left_wrist");
    // What the draft says can be read back.
    EXPECT_THAT(ParseSkeletonMap(SkeletonMapText(*map), "draft"), IsOk());
    EXPECT_THAT(CheckMapFits(*map, skeleton), IsOk());
  }
}

TEST(SkeletonMapsTest, ASkeletonWithoutLegsCannotBeDrafted) {
  SourceSkeleton snake;
  snake.joints.push_back({"a", -1, Eigen::Vector3d::Zero()});
  snake.joints.push_back({"b", 0, Eigen::Vector3d::UnitX()});
  EXPECT_THAT(DraftSkeletonMap(snake, "draft"),
              Refused("found none for left_hip, left_knee, left_ankle"));
}

}  // namespace
}  // namespace sinew::import
