#include "sim/import/formats/quaternion_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/import/formats/robot_csv.h"
#include "sim/import/formats/robot_layout.h"
#include "sim/import/formats/testing/recordings.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const character::Character& G1() {
  static const character::Character& g1 =
      *character::Character::Load("g1", v1::Physics())->release();
  return g1;
}

const std::vector<v1::RobotLayout>& Layouts() {
  static const auto& layouts =
      *new std::vector<v1::RobotLayout>(*KnownRobotLayouts());
  return layouts;
}

// A G1 that stands with its knees bent and turns from `from` to `to` rad about
// the vertical while it leans `lean` rad forward from the ankles.
std::string TurningG1(const std::string& order, double from, double to,
                      double lean) {
  constexpr int kFrames = 60;
  std::string text;
  for (int i = 0; i < kFrames; ++i) {
    const double yaw = from + (to - from) * i / (kFrames - 1);
    const Eigen::Quaterniond q =
        motion::YawRotation(yaw) *
        Eigen::Quaterniond(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY()));
    std::vector<double> row = {0, 0, 0.757};
    const Eigen::Vector4d xyzw = q.coeffs();
    for (int k = 0; k < 4; ++k) {
      row.push_back(xyzw[order == "xyzw" ? k : (k + 3) % 4]);
    }
    std::vector<double> joints(29, 0);
    for (const int leg : {0, 6}) {
      joints[leg] = -0.312;
      joints[leg + 3] = 0.669;
      joints[leg + 4] = -0.363 - lean;
    }
    row.insert(row.end(), joints.begin(), joints.end());
    absl::StrAppend(&text, absl::StrJoin(row, " "), "\n");
  }
  return text;
}

absl::StatusOr<RobotClip> Parse(const std::string& text) {
  return ParseRobotCsv(text, "clip", "clip.csv", {.frames_per_second = 30},
                       Layouts());
}

TEST(QuaternionOrder, IsConcludedFromFeetThatStandOnTheFloor) {
  for (const std::string order : {"wxyz", "xyzw"}) {
    const auto clip = Parse(TurningG1(order, 0.3, 1.2, 0.05));
    ASSERT_THAT(clip, IsOk());

    const auto conclusion = CompareQuaternionOrders(*clip, *G1().model());

    ASSERT_THAT(conclusion, IsOk());
    EXPECT_EQ(conclusion->order(), order);
  }
}

TEST(QuaternionOrder, IsSettledInTheClipAndItsFacts) {
  auto clip = Parse(TurningG1("xyzw", 0.5, 0.5, 0));
  ASSERT_THAT(clip, IsOk());

  ASSERT_THAT(SettleQuaternionOrder(*G1().model(), &*clip), IsOk());

  EXPECT_EQ(clip->facts.quaternion_order(), "xyzw");
  EXPECT_THAT(clip->facts.concluded(), ElementsAre("quaternion_order"));
  EXPECT_NEAR(motion::Yaw(clip->poses[0].root_rotation), 0.5, 1e-5);
  EXPECT_TRUE(clip->warnings.empty());
}

TEST(QuaternionOrder, ThatIsKnownIsLeftAlone) {
  auto clip = Parse(TurningG1("xyzw", 0.5, 0.5, 0));
  ASSERT_THAT(clip, IsOk());
  clip->facts.set_quaternion_order("wxyz");

  ASSERT_THAT(SettleQuaternionOrder(*G1().model(), &*clip), IsOk());

  EXPECT_EQ(clip->facts.quaternion_order(), "wxyz");
  EXPECT_TRUE(clip->facts.concluded().empty());
}

TEST(QuaternionOrder, ABodyThatNeverTurnsFromXStandsEitherWay) {
  auto clip = Parse(TurningG1("xyzw", 0, 0, 0));
  ASSERT_THAT(clip, IsOk());

  ASSERT_THAT(SettleQuaternionOrder(*G1().model(), &*clip), IsOk());

  EXPECT_THAT(clip->warnings,
              Contains(HasSubstr("the other order fits nearly as well")));
}

TEST(QuaternionOrder, NeedsAModelThatCanPlayTheClip) {
  const auto clip = ParseRobotCsv(
      "0 0 1 1 0 0 0 0\n0 0 1 1 0 0 0 0\n", "clip", "clip.csv", {},
      {*ParseRobotLayout("name: \"tail\" joints: \"tail\"", "")});
  ASSERT_THAT(clip, IsOk());

  EXPECT_THAT(CompareQuaternionOrders(*clip, *G1().model()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("joints of the clip (tail ...), found none")));
}

TEST(QuaternionOrder, IsConcludedForEveryRealRecording) {
  int read = 0;
  double least_margin = 1e9;
  std::string least;
  for (const char* place :
       {"motions/g1_moves/csv", "motions/asap/g1_csv_converted"}) {
    const auto recordings = testing::Recordings(place, ".csv");
    if (recordings.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
    for (const auto& [name, text] : recordings) {
      const auto clip = ParseRobotCsv(text, name, name, {}, Layouts());
      ASSERT_THAT(clip, IsOk());
      const auto conclusion = CompareQuaternionOrders(*clip, *G1().model());
      ASSERT_THAT(conclusion, IsOk());
      EXPECT_EQ(conclusion->order(), "xyzw") << name;
      const double margin = conclusion->wxyz.score() / conclusion->xyzw.score();
      if (margin < least_margin) least = name;
      least_margin = std::min(least_margin, margin);
      ++read;
    }
  }
  EXPECT_GE(read, 90);
  RecordProperty("least_margin", absl::StrCat(least_margin, " ", least));
  EXPECT_GT(least_margin, 1.2) << least;
}

}  // namespace
}  // namespace sinew::import
