#include "tools/motion_report/motion_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <stb/stb_image.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "nlohmann/json.hpp"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/import/importer.h"
#include "sim/import/testing/made_clips.h"
#include "tools/motion_report/body_shapes.h"
#include "tools/motion_report/page.h"
#include "tools/motion_report/trajectory.h"
#include "tools/report/testing/browser.h"

namespace sinew::motion_report {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using Json = nlohmann::json;

character::ModelPtr Compile(const std::string& mjcf) {
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  SINEW_CHECK(mj_addBufferVFS(&vfs, "model.xml", mjcf.data(),
                              static_cast<int>(mjcf.size())) == 0);
  char error[500] = "";
  mjModel* model = mj_loadXML("model.xml", &vfs, error, sizeof(error));
  mj_deleteVFS(&vfs);
  SINEW_CHECK(model != nullptr) << error;
  return character::ModelPtr(model);
}

TEST(BodyShapes, AreTheGeomsOfEachBody) {
  const auto model = Compile(R"(<mujoco><worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="trunk" pos="0 0 1"><freejoint/>
      <geom type="box" size=".1 .2 .3" pos="0 0 .1"/>
      <body name="ball" pos="1 0 0"><geom type="sphere" size=".05"/></body>
    </body></worldbody></mujoco>)");

  const Json bodies = BodyShapes(*model);

  ASSERT_THAT(bodies, SizeIs(2));
  EXPECT_EQ(bodies[0]["name"], "trunk");
  EXPECT_EQ(bodies[0]["shapes"][0]["type"], "box");
  EXPECT_EQ(bodies[0]["shapes"][0]["size"], Json({0.1, 0.2, 0.3}));
  EXPECT_EQ(bodies[0]["shapes"][0]["position"], Json({0., 0., 0.1}));
  EXPECT_EQ(bodies[1]["shapes"][0]["type"], "sphere");
}

TEST(BodyShapes, AMeshIsACapsuleOrABoxAroundIt) {
  // A bar along x and a cube.
  const auto model = Compile(R"(<mujoco><asset>
    <mesh name="bar" vertex="0 0 0 1 0 0 0 .1 0 1 .1 0 0 0 .1 1 0 .1 0 .1 .1
                             1 .1 .1"/>
    <mesh name="cube" vertex="0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1"/>
    </asset><worldbody><body><freejoint/>
      <geom type="mesh" mesh="bar"/><geom type="mesh" mesh="cube"/>
    </body></worldbody></mujoco>)");

  const Json shapes = BodyShapes(*model)[0]["shapes"];

  ASSERT_THAT(shapes, SizeIs(2));
  EXPECT_EQ(shapes[0]["type"], "capsule");
  EXPECT_NEAR(shapes[0]["size"][0], 0.05, 1e-6);  // radius
  EXPECT_NEAR(shapes[0]["size"][1], 0.45, 1e-6);  // half length without caps
  EXPECT_NEAR(shapes[0]["position"][0], 0.5, 1e-6);
  // Capsules lie along z.
  const auto rotation = shapes[0]["rotation"].get<std::vector<double>>();
  ASSERT_THAT(rotation, SizeIs(4));
  const double z[3] = {0, 0, 1};
  double axis[3];
  mju_rotVecQuat(axis, z, rotation.data());
  EXPECT_NEAR(std::abs(axis[0]), 1, 1e-3);
  EXPECT_EQ(shapes[1]["type"], "box");
}

TEST(BodyShapes, ABodyWithoutGeomsIsABoneToItsChildren) {
  const auto model = Compile(R"(<mujoco><worldbody><body><freejoint/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <body pos="0 0 .4"><geom size=".1"/></body>
    </body></worldbody></mujoco>)");

  const Json shapes = BodyShapes(*model)[0]["shapes"];

  ASSERT_THAT(shapes, SizeIs(1));
  EXPECT_EQ(shapes[0]["type"], "capsule");
  EXPECT_EQ(shapes[0]["position"], Json({0., 0., 0.2}));
}

// One body that rises by a metre per second from (3, 4, 0).
TensorMap Rising(int frames, double rate) {
  std::vector<float> position, rotation;
  for (int t = 0; t < frames; ++t) {
    position.insert(position.end(), {3, 4, static_cast<float>(t / rate)});
    rotation.insert(rotation.end(), {1, 0, 0, 0});
  }
  TensorMap map;
  map["body_position"] = HostTensor::Float32({frames, 1, 3}, position);
  map["body_rotation"] = HostTensor::Float32({frames, 1, 4}, rotation);
  return map;
}

std::vector<int16_t> Unpack(const std::string& base64) {
  std::string bytes;
  SINEW_CHECK(absl::Base64Unescape(base64, &bytes));
  std::vector<int16_t> numbers;
  for (size_t i = 0; i + 1 < bytes.size(); i += 2) {
    numbers.push_back(static_cast<int16_t>(
        static_cast<uint8_t>(bytes[i]) |
        static_cast<uint16_t>(static_cast<uint8_t>(bytes[i + 1])) << 8));
  }
  return numbers;
}

TEST(Trajectory, IsInMillimetresFromWhereItBegins) {
  const auto shown = MakeTrajectory(Rising(11, 30), 30, {});

  ASSERT_THAT(shown, IsOk());
  EXPECT_EQ(shown->frames, 11);
  EXPECT_FALSE(shown->cut);
  const std::vector<int16_t> place = Unpack(shown->body_position);
  ASSERT_THAT(place, SizeIs(33));
  EXPECT_EQ(place[0], 0);
  EXPECT_EQ(place[1], 0);
  EXPECT_EQ(place[3 * 3 + 2], 100);  // 3 / 30 s at 1 m/s
  EXPECT_EQ(Unpack(shown->body_rotation)[0], 32767);
}

TEST(Trajectory, OfALongFastClipIsItsThinnedBeginning) {
  const auto shown = MakeTrajectory(Rising(6000, 120), 120, {});

  ASSERT_THAT(shown, IsOk());
  EXPECT_EQ(shown->frames_per_second, 30);
  EXPECT_EQ(shown->frames, 301);
  EXPECT_TRUE(shown->cut);
  EXPECT_EQ(Unpack(shown->body_position)[3 * 30 + 2], 1000);  // after a second
}

TEST(Trajectory, EndsWhereTheRootLeavesItsReach) {
  // Walks 40 m along x, 4 m/s.
  constexpr int kFrames = 301;
  TensorMap walk = Rising(kFrames, 30);
  std::vector<float> position;
  for (int t = 0; t < kFrames; ++t) {
    position.insert(position.end(), {3 + 4 * t / 30.0F, 4, 1});
  }
  walk["body_position"] = HostTensor::Float32({kFrames, 1, 3}, position);

  const auto shown = MakeTrajectory(walk, 30, {});

  ASSERT_THAT(shown, IsOk());
  EXPECT_TRUE(shown->cut);
  EXPECT_EQ(shown->frames, 226);  // 30 m after 7.5 s
  const std::vector<int16_t> place = Unpack(shown->body_position);
  ASSERT_THAT(place, SizeIs(3 * 226));
  EXPECT_EQ(place[3 * 225], 30000);
}

TEST(Trajectory, HasTheSourceInTheSamePlace) {
  import::SourcePreview source;
  source.frames_per_second = 30;
  source.parents = {-1, 0};
  for (int t = 0; t < 5; ++t) {
    const std::vector<float> joints = {3, 4, 1, 3.5, 4, 1};
    source.positions.insert(source.positions.end(), joints.begin(),
                            joints.end());
  }

  const auto shown = MakeTrajectory(Rising(11, 30), 30, source);

  ASSERT_THAT(shown, IsOk());
  EXPECT_EQ(shown->frames, 5);
  EXPECT_EQ(shown->source_parents, source.parents);
  EXPECT_EQ(Unpack(shown->source_position)[3], 500);
}

TEST(Trajectory, NeedsBodies) {
  EXPECT_THAT(
      MakeTrajectory({}, 30, {}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("body_position")));
}

TEST(Page, LetsNoDataActAsMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--";

  const std::string page = MakePage({{"library", hostile}}, {});

  EXPECT_THAT(page, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script\\u003e"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

// --- Of a library -----------------------------------------------------------

class ImportedLibrary : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = JoinPath(
        ::testing::TempDir(),
        ::testing::UnitTest::GetInstance()->current_test_info()->name());
    library_ = JoinPath(folder_, "clips");
    SINEW_CHECK(RemoveRecursively(folder_).ok());
    SINEW_CHECK(MakeDirectories(folder_).ok());
    auto character = character::Character::Load("humanoid", v1::Physics());
    SINEW_CHECK(character.ok()) << character.status().ToString();
    character_ = *std::move(character);
    std::vector<import::ClipReport> reports;
    const absl::Status imported = import::ImportFiles(
        *character_,
        {Write("march <b>.txt", import::testing::MarchJson()),
         Write("lying.txt", import::testing::LyingJson()),
         Write("broken.txt", "{}")},
        {}, library_, &reports);
    SINEW_CHECK(imported.ok()) << imported.ToString();
  }

  std::string Write(const std::string& name, const std::string& text) {
    const std::string path = JoinPath(folder_, name);
    SINEW_CHECK(WriteFileAtomically(path, text).ok());
    return path;
  }

  // What headless Chromium writes to its standard output.
  std::string Browse(const std::string& page, std::vector<std::string> flags) {
    flags.insert(flags.begin(),
                 {"--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                  "--virtual-time-budget=1500"});
    return report::testing::Browse(page, folder_, flags);
  }

  std::string folder_, library_;
  std::unique_ptr<const character::Character> character_;
};

// Pixels in which one colour stands out as it does in `like`.
struct Colours {
  int64_t teal = 0;    // the character
  int64_t orange = 0;  // the source
  std::set<int> different;
};

Colours ColoursOf(const std::string& png) {
  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load(png.c_str(), &width, &height, &channels, 3);
  SINEW_CHECK(pixels != nullptr) << png;
  Colours found;
  for (int64_t i = 0; i < int64_t{width} * height; ++i) {
    const int r = pixels[3 * i], g = pixels[3 * i + 1], b = pixels[3 * i + 2];
    found.different.insert(r << 16 | g << 8 | b);
    found.teal += g > r + 40 && b > r + 40 ? 1 : 0;
    found.orange += r > b + 60 && g > b + 20 && r > g + 20 ? 1 : 0;
  }
  stbi_image_free(pixels);
  return found;
}

TEST_F(ImportedLibrary, IsShownAndPlayedByARealBrowser) {
  const auto path =
      WriteMotionReport(*character_, library_, {.pictures = 1}, StopToken());
  ASSERT_THAT(path, IsOk());

  const std::string dom =
      Browse(*path, {"--dump-dom", "--window-size=1300,1400"});

  EXPECT_THAT(
      dom, AllOf(HasSubstr("2 of 3 clips"), HasSubstr("march &lt;b&gt;"),
                 HasSubstr("broken.txt"), HasSubstr("retarget error"),
                 HasSubstr("Limits: what warns"), HasSubstr("data:image/jpeg"),
                 Not(HasSubstr("which the viewer draws with.</"))));
  const std::string picture = JoinPath(folder_, "page.png");
  Browse(*path,
         {absl::StrCat("--screenshot=", picture), "--window-size=1300,1400"});
  const Colours colours = ColoursOf(picture);
  EXPECT_GT(colours.different.size(), 1000u);
  EXPECT_GT(colours.teal, 2000);   // of a body of some 150 x 300 pixels
  EXPECT_GT(colours.orange, 400);  // thin bones
}

TEST_F(ImportedLibrary, SaysWhatItCannotShow) {
  ASSERT_THAT(RemoveRecursively(JoinPath(library_, "cache")), IsOk());

  const auto path = WriteMotionReport(*character_, library_, {}, StopToken());

  ASSERT_THAT(path, IsOk());
  EXPECT_THAT(*ReadFile(*path), AllOf(HasSubstr(JoinPath(library_, "cache/")),
                                      Not(HasSubstr("trajectory-0"))));
}

TEST_F(ImportedLibrary, FitsIntoItsMegabytes) {
  const auto path = WriteMotionReport(
      *character_, library_, {.pictures = 0, .trajectory_megabytes = 0},
      StopToken());

  ASSERT_THAT(path, IsOk());
  EXPECT_THAT(*ReadFile(*path), AllOf(Not(HasSubstr("id=\"trajectory-0\"")),
                                      Not(HasSubstr("data:image/jpeg;"))));
}

TEST_F(ImportedLibrary, NamesAClipThatIsNotThere) {
  EXPECT_THAT(WriteMotionReport(*character_, library_, {.clips = {"walk"}},
                                StopToken()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("\"walk\"")));
}

TEST_F(ImportedLibrary, IsNotMistakenForAnotherJson) {
  ASSERT_THAT(WriteFileAtomically(JoinPath(library_, "report.json"), "[]"),
              IsOk());
  EXPECT_THAT(WriteMotionReport(*character_, library_, {}, StopToken()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected the report of an import")));
}

}  // namespace
}  // namespace sinew::motion_report
