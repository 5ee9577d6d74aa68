#include "tools/render/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "tools/render/film_strip.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::render {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr int kWidth = 120;
constexpr int kHeight = 160;

// Where Bazel keeps what a test wants to show; look at these by eye.
void Keep(const std::string& name, const std::string& png) {
  if (const char* folder = std::getenv("TEST_UNDECLARED_OUTPUTS_DIR")) {
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder, name), png), IsOk());
  }
}

// Share of pixels that differ by more than the eye overlooks.
double ShareThatDiffers(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgb.size(), b.rgb.size());
  int count = 0;
  for (size_t i = 0; i < a.rgb.size(); i += 3) {
    const int difference = std::abs(a.rgb[i] - b.rgb[i]) +
                           std::abs(a.rgb[i + 1] - b.rgb[i + 1]) +
                           std::abs(a.rgb[i + 2] - b.rgb[i + 2]);
    if (difference > 60) ++count;
  }
  return count / (a.rgb.size() / 3.0);
}

class Pictures : public ::testing::Test {
 protected:
  void SetUp() override {
    auto loaded = character::Character::Load("humanoid", v1::Physics());
    ASSERT_THAT(loaded, IsOk());
    humanoid_ = *std::move(loaded);
    auto created =
        OffscreenRenderer::Create(PictureModel(*humanoid_), kWidth, kHeight);
    ASSERT_THAT(created, IsOk());
    renderer_ = *std::move(created);
  }

  std::vector<double> Rest() const {
    const mjModel* model = humanoid_->model();
    return std::vector<double>(model->qpos0, model->qpos0 + model->nq);
  }
  std::vector<double> Bent(const std::string& joint, double angle) const {
    std::vector<double> qpos = Rest();
    for (const character::JointInfo& info : humanoid_->joints()) {
      if (info.name == joint) qpos[info.qpos_address] = angle;
    }
    return qpos;
  }
  Image Draw(const std::vector<double>& qpos, const Camera& camera = {}) {
    auto image = renderer_->Render({{{qpos, std::nullopt}}}, camera);
    EXPECT_THAT(image, IsOk());
    return *std::move(image);
  }

  std::unique_ptr<character::Character> humanoid_;
  std::unique_ptr<OffscreenRenderer> renderer_;
};

TEST_F(Pictures, ShowTheBodyBetweenFloorAndSky) {
  const Image image = Draw(Rest());

  // The same scene with the body out of sight.
  std::vector<double> away = Rest();
  away[1] = -100;
  const Image empty = Draw(away);
  const double share = ShareThatDiffers(image, empty);
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.4);
  // Red thigh (its right side is nearer): redder than blue at mid height.
  const size_t middle = 3 * (size_t{kHeight} * 62 / 100 * kWidth + kWidth / 2);
  EXPECT_GT(image.rgb[middle], image.rgb[middle + 2] + 30);
}

TEST_F(Pictures, AreTheSameForTheSamePose) {
  const Image first = Draw(Rest());
  Draw(Bent("left_knee", 1));

  EXPECT_EQ(Draw(Rest()).rgb, first.rgb);
}

TEST_F(Pictures, ChangeWithThePose) {
  EXPECT_GT(ShareThatDiffers(Draw(Rest()), Draw(Bent("right_hip_y", 1.2))),
            0.01);
}

TEST_F(Pictures, ShowAGhostBesideTheBody) {
  std::vector<double> ahead = Rest();
  ahead[0] += 0.6;
  const std::vector<double> here = Rest();
  const Figure body = {here, std::nullopt};
  const Figure ghost = {ahead, std::array<float, 4>{0.1f, 0.8f, 0.2f, 0.5f}};

  const auto both = renderer_->Render({{body, ghost}}, Camera());

  ASSERT_THAT(both, IsOk());
  const Image alone = Draw(here);
  int green = 0;
  for (size_t i = 0; i < both->rgb.size(); i += 3) {
    if (both->rgb[i + 1] > both->rgb[i] + 30 && both->rgb != alone.rgb) {
      ++green;
    }
  }
  EXPECT_GT(green, 100);
}

TEST_F(Pictures, RefuseAPoseOfAnotherLengthOrWithoutNumbers) {
  const std::vector<double> few(7, 0.0);
  EXPECT_THAT(renderer_->Render({{{few, std::nullopt}}}, Camera()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "rendering: expected a pose of 35 numbers, found 7"));
  std::vector<double> broken = Rest();
  broken[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(
      renderer_->Render({{{broken, std::nullopt}}}, Camera()),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("nan at 4")));
  EXPECT_THAT(renderer_->Render({}, Camera()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("at least one figure")));
}

TEST_F(Pictures, RefuseSizesOutOfRange) {
  EXPECT_THAT(
      OffscreenRenderer::Create(PictureModel(*humanoid_), 8, kHeight),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("found 8 x 160")));
}

TEST_F(Pictures, PutReferenceAboveSimulationInAStrip) {
  std::vector<double> reference, simulated;
  for (int frame = 0; frame < 31; ++frame) {
    const std::vector<double> pose = Bent("right_hip_y", 0.04 * frame);
    reference.insert(reference.end(), pose.begin(), pose.end());
    const std::vector<double> rest = Rest();
    simulated.insert(simulated.end(), rest.begin(), rest.end());
  }
  const int nq = humanoid_->model()->nq;

  const auto strip =
      FilmStrip(*renderer_, {reference, nq}, {simulated, nq}, 4, 30);

  ASSERT_THAT(strip, IsOk());
  EXPECT_EQ(strip->width, 4 * kWidth);
  EXPECT_EQ(strip->height, 2 * kHeight);
  const auto png = EncodePng(*strip);
  ASSERT_THAT(png, IsOk());
  Keep("strip.png", *png);
}

TEST_F(Pictures, RefuseAStripWithoutFrames) {
  const int nq = humanoid_->model()->nq;
  const std::vector<double> rest = Rest();

  EXPECT_THAT(FilmStrip(*renderer_, {rest, nq}, {{}, nq}, 3),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("simulated: expected frames of 35 numbers")));
  EXPECT_THAT(FilmStrip(*renderer_, {rest, nq}, {rest, nq}, 0),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("columns: expected at least 1")));
}

TEST_F(Pictures, ComeBackUnchangedFromTheirPng) {
  const auto png = RenderPose(*humanoid_, Rest(), Camera(), {kWidth, kHeight});
  ASSERT_THAT(png, IsOk());
  Keep("rest.png", *png);

  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load_from_memory(
      reinterpret_cast<const stbi_uc*>(png->data()),
      static_cast<int>(png->size()), &width, &height, &channels, 3);
  ASSERT_NE(pixels, nullptr);
  const std::vector<uint8_t> decoded(pixels, pixels + 3 * width * height);
  stbi_image_free(pixels);
  EXPECT_EQ(width, kWidth);
  EXPECT_EQ(height, kHeight);
  EXPECT_EQ(decoded, Draw(Rest()).rgb);
}

TEST(PictureModel, FallsBackToThePhysicsModelOfAnUnknownCharacter) {
  auto humanoid = character::Character::Load("humanoid", v1::Physics());
  ASSERT_THAT(humanoid, IsOk());
  std::string text = (*humanoid)->character_text();
  const size_t at = text.find("\"humanoid\"");
  text.replace(at, 10, "\"stranger\"");
  auto stranger = character::Character::FromAssets(
      text, (*humanoid)->model_binary(), "test");
  ASSERT_THAT(stranger, IsOk());

  EXPECT_EQ(PictureModel(**stranger)->ntex, 0);
  EXPECT_GT(PictureModel(**humanoid)->ntex, 0);
}

}  // namespace
}  // namespace sinew::render
