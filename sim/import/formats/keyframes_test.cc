#include "sim/import/formats/keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/recordings.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::BadFile;
using testing::CheckClip;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Two legs of a hinge each, one through a frame, and a tail whose type is a
// class's. The order of qpos: root, left_knee, right_knee, tail.
constexpr char kModel[] = R"(
  <default>
    <joint damping="1"/>
    <default class="ball"><joint type="ball"/>
      <default class="tails"><joint type="hinge"/></default>
    </default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="pelvis">
      <body name="left"><joint name="left_knee"/></body>
      <frame>
        <body name="right"><joint name="right_knee" type="hinge"/></body>
      </frame>
      <freejoint/>
    </body>
    <body name="behind" childclass="ball">
      <joint name="tail" class="tails"/>
    </body>
    <body name="hand" mocap="true"/>
    <body name="foot" mocap="true"/>
  </worldbody>)";

std::string File(const std::string& keys, const std::string& model = kModel) {
  return absl::StrCat("<mujoco>", model, "<keyframe>", keys,
                      "</keyframe></mujoco>");
}

constexpr char kKeys[] =
    "<key time='1' qpos='1 2 3 0.6 0 0 0.8 0.1 0.2 0.3'/>"
    "<key time='1.5' qpos='1 2 4 0.6 0 0 0.8 0.1 0.2 0.4'/>";

absl::StatusOr<RobotClip> Parse(const std::string& text,
                                const ReadOptions& options = {}) {
  return ParseKeyframes(text, "jump", "dir/jump.xml", options);
}

TEST(Keyframes, ReadsTheCoordinatesOfTheModelBesideThem) {
  const auto clip = Parse(File(kKeys));

  ASSERT_THAT(clip, IsOk());
  CheckClip(*clip);
  EXPECT_THAT(clip->joints, ElementsAre("left_knee", "right_knee", "tail"));
  EXPECT_DOUBLE_EQ(clip->duration(), 0.5);
  EXPECT_DOUBLE_EQ(clip->facts.frames_per_second(), 2);
  EXPECT_EQ(clip->facts.format(), "keyframes");
  EXPECT_THAT(clip->facts.concluded(), IsEmpty());
  EXPECT_EQ(clip->poses[1].root_position, Vector3d(1, 2, 4));
  EXPECT_DOUBLE_EQ(clip->poses[1].root_rotation.w(), 0.6);
  EXPECT_EQ(clip->poses[1].joints, Vector3d(0.1, 0.2, 0.4));
}

TEST(Keyframes, WithoutTimesHaveTheGivenRateOrTheDefault) {
  const std::string keys =
      "<key qpos='0 0 1 1 0 0 0 0 0 0'/><key qpos='0 0 1 1 0 0 0 0 0 0'/>";
  const auto by_default = Parse(File(keys));
  ASSERT_THAT(by_default, IsOk());
  EXPECT_DOUBLE_EQ(by_default->facts.frames_per_second(), kDefaultKeyRate);
  EXPECT_THAT(by_default->facts.concluded(), ElementsAre("frames_per_second"));
  EXPECT_THAT(by_default->warnings, ElementsAre(HasSubstr("say no times")));

  const auto given = Parse(File(keys), {.frames_per_second = 60});
  ASSERT_THAT(given, IsOk());
  EXPECT_DOUBLE_EQ(given->facts.frames_per_second(), 60);
  EXPECT_THAT(given->warnings, IsEmpty());
}

TEST(Keyframes, RefuseUnitsAndAxesThatMuJoCoHasNot) {
  const std::string keys =
      "<key qpos='0 0 1 1 0 0 0 0 0 0'/><key qpos='0 0 1 1 0 0 0 0 0 0'/>";
  EXPECT_THAT(Parse(File(keys), {.metres_per_unit = 0.01}).status().message(),
              HasSubstr("metres_per_unit: expected 1"));
  EXPECT_THAT(Parse(File(keys), {.up_axis = 'y'}).status().message(),
              HasSubstr("up_axis: expected z"));
}

TEST(Keyframes, OfMarkersAreNamedAfterTheModelsMocapBodies) {
  const auto clip = ParseMarkerKeyframes(
      File("<key mpos='1 2 3 4 5 6'/><key mpos='1 2 3 4 5 7'/>"), "jump",
      "jump.xml", {});

  ASSERT_THAT(clip, IsOk());
  EXPECT_THAT(clip->markers, ElementsAre("hand", "foot"));
  EXPECT_EQ(clip->positions[1][1], Vector3d(4, 5, 7));
  EXPECT_EQ(clip->times.size(), 2u);
}

class KeyframesError : public ::testing::TestWithParam<BadFile> {};

TEST_P(KeyframesError, NamesFileKeyExpectedAndFound) {
  EXPECT_THAT(Parse(GetParam().text),
              testing::IsRefused("dir/jump.xml: ", GetParam().expected));
}

INSTANTIATE_TEST_SUITE_P(
    Files, KeyframesError,
    ::testing::Values(
        BadFile{"", "expected XML"}, BadFile{"<mujoco>", "expected XML"},
        BadFile{"<robot/>", "expected a <mujoco> element, found <robot>"},
        BadFile{"<mujoco/>", "expected at least 2 keys"},
        BadFile{File("<key qpos='0'/>"), "<keyframe>, found 1"},
        BadFile{File(kKeys, ""),
                "expected a model with a free joint and hinges beside the "
                "keys, found none"},
        BadFile{File("<key name='a' mpos='1 2 3'/><key mpos='1 2 3'/>"),
                "key 0 (\"a\"): qpos: expected the model's coordinates, found "
                "mpos alone: positions of markers"},
        BadFile{File("<key/><key/>"), "coordinates, found none"}));

INSTANTIATE_TEST_SUITE_P(
    Keys, KeyframesError,
    ::testing::Values(
        BadFile{File(absl::StrCat(kKeys, "<key time='3' qpos='1 2'/>")),
                "key 2 (\"\"): qpos: expected 10 numbers, as its model has, "
                "found 2"},
        BadFile{
            File(absl::StrCat(kKeys,
                              "<key time='1.5' qpos='0 0 1 1 0 0 0 0 0 0'/>")),
            "key 2 (\"\"): time: expected at least 0.0001 s more than the "
            "1.5 s of the key before, found 1.5"},
        BadFile{File("<key time='0' qpos='0 0 1 1 0 0 0 0 0 0'/>"
                     "<key time='1e-320' qpos='0 0 1 1 0 0 0 0 0 0'/>"),
                "key 1 (\"\"): time: expected at least 0.0001 s more"},
        BadFile{
            File(absl::StrCat(kKeys,
                              "<key time='3' qpos='0 0 1 1 1 0 0 0 0 0'/>")),
            "expected a unit quaternion (norm 1 +- 0.01), found norm 1.41"},
        BadFile{
            File(absl::StrCat(kKeys,
                              "<key time='3' qpos='0 0 nan 1 0 0 0 0 0 0'/>")),
            "expected numbers within +-1e+06, found \"nan\""},
        BadFile{File(absl::StrCat(kKeys, "<key time='soon' qpos='0'/>")),
                "time: expected numbers within +-1e+06, found \"soon\""}));

std::string Model(const std::string& joints) {
  return absl::StrCat("<worldbody><body>", joints, "</body></worldbody>");
}

INSTANTIATE_TEST_SUITE_P(
    Models, KeyframesError,
    ::testing::Values(
        BadFile{File(kKeys, Model("<joint name='a' type='slide'/>")),
                "expected a free joint and hinges, found <joint name=\"a\" "
                "type=\"slide\">"},
        BadFile{File(kKeys, Model("<freejoint/><joint/>")),
                "expected hinges with names, each once"},
        BadFile{File(kKeys, Model("<joint name='a'/><freejoint/>")),
                "expected one free joint, before all others"},
        BadFile{File(kKeys, Model("<freejoint/>")), "found no hinges"},
        BadFile{File(kKeys, Model("<joint name='a'/>")), "found no free joint"},
        BadFile{File(kKeys, "<include file='robot.xml'/>"),
                "expected a model in one file, found <include"},
        BadFile{File(kKeys, Model("<replicate count='1000000000'/>")),
                "expected a model in one file, found <replicate"}));

TEST(Keyframes, RefusesAClipOfMoreThanFourHours) {
  EXPECT_THAT(Parse(File(absl::StrCat(
                  kKeys, "<key time='20000' qpos='0 0 1 1 0 0 0 0 0 0'/>"))),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("expected at most 14400 seconds")));
}

TEST(Keyframes, DeepNestingIsAnErrorAndNotACrash) {
  std::string model;
  for (int i = 0; i < 100000; ++i) model += "<worldbody>";
  EXPECT_THAT(
      Parse(File(kKeys, model)),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("expected XML")));
}

TEST(Keyframes, AnyTruncationIsAnErrorAndNotACrash) {
  const std::string text = File(kKeys);
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(Parse(text.substr(0, size)).ok());
  }
}

TEST(Keyframes, ReadsTheMarkersOfRealFiles) {
  const auto recordings =
      testing::Recordings("motions/mjpc_cmu_keyframes", ".xml");
  if (recordings.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
  for (const auto& [name, text] : recordings) {
    EXPECT_THAT(Parse(text), StatusIs(absl::StatusCode::kInvalidArgument,
                                      HasSubstr("qpos: expected")));
    const auto clip = ParseMarkerKeyframes(text, name, name, {});
    ASSERT_THAT(clip, IsOk());
    ASSERT_EQ(clip->markers.size(), 16u) << name;
    EXPECT_EQ(clip->markers[0], "pelvis");
    // Which marker is which: the head is above the pelvis, the hips a body's
    // width apart, and each knee between hip and heel.
    const auto at = [&](const char* marker) {
      const auto found =
          std::find(clip->markers.begin(), clip->markers.end(), marker);
      return clip->positions[0][found - clip->markers.begin()];
    };
    EXPECT_GT(at("head").z(), at("pelvis").z()) << name;
    EXPECT_NEAR((at("lhip") - at("rhip")).norm(), 0.14, 0.05) << name;
    for (const std::string side : {"l", "r"}) {
      const double thigh =
          (at((side + "hip").c_str()) - at((side + "knee").c_str())).norm();
      EXPECT_NEAR(thigh, 0.39, 0.08) << name;
    }
  }
  EXPECT_EQ(recordings.size(), 10u);
}

}  // namespace
}  // namespace sinew::import
