#include "tools/render/offscreen_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::render {
namespace {

constexpr int kMinPixels = 16;
constexpr int kMaxPixels = 4096;
constexpr int kMaxGeoms = 2000;
constexpr int kFontScale = mjFONTSCALE_100;
// Degrees; narrow, so that a body looks alike wherever it stands.
constexpr float kFieldOfView = 35;
// Metres from the camera's target to a lamp.
constexpr float kLampDistance = 4;
// Multisampling of edges.
constexpr int kSamples = 4;

mjvCamera ToMujoco(const Camera& camera) {
  mjvCamera result;
  mjv_defaultCamera(&result);
  result.type = mjCAMERA_FREE;
  std::copy(camera.target.begin(), camera.target.end(), result.lookat);
  result.distance = camera.distance;
  result.azimuth = camera.azimuth_deg;
  result.elevation = camera.elevation_deg;
  return result;
}

// Shadows fall only within a box around a lamp: takes the lamps along with the
// camera's target.
void MoveLamps(const mjvCamera& camera, mjvScene* scene) {
  for (int i = 0; i < scene->nlight; ++i) {
    mjvLight& lamp = scene->lights[i];
    if (lamp.headlight || lamp.type != mjLIGHT_DIRECTIONAL) continue;
    for (int k = 0; k < 3; ++k) {
      lamp.pos[k] =
          static_cast<float>(camera.lookat[k]) - kLampDistance * lamp.dir[k];
    }
  }
}

}  // namespace

character::ModelPtr PictureModel(const character::Character& character) {
  const mjModel* physics = character.model();
  auto pictures = character::Character::CompileForPictures(character.name());
  if (pictures.ok() && (*pictures)->nq == physics->nq &&
      (*pictures)->nbody == physics->nbody) {
    return *std::move(pictures);
  }
  return character::ModelPtr(mj_copyModel(nullptr, physics));
}

absl::StatusOr<std::unique_ptr<OffscreenRenderer>> OffscreenRenderer::Create(
    character::ModelPtr model, int width, int height) {
  for (int size : {width, height}) {
    if (size < kMinPixels || size > kMaxPixels) {
      return absl::InvalidArgumentError(absl::StrCat(
          "rendering: expected a picture of ", kMinPixels, " to ", kMaxPixels,
          " pixels each way, found ", width, " x ", height));
    }
  }
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<GlContext> context,
                         GlContext::Create());
  SINEW_RETURN_IF_ERROR(context->MakeCurrent());
  model->vis.global.offwidth = width;
  model->vis.global.offheight = height;
  model->vis.global.fovy = kFieldOfView;
  model->vis.quality.offsamples = kSamples;
  return std::unique_ptr<OffscreenRenderer>(new OffscreenRenderer(
      std::move(model), std::move(context), width, height));
}

OffscreenRenderer::OffscreenRenderer(character::ModelPtr model,
                                     std::unique_ptr<GlContext> context,
                                     int width, int height)
    : model_(std::move(model)),
      data_(mj_makeData(model_.get())),
      context_(std::move(context)),
      width_(width),
      height_(height) {
  mjv_defaultScene(&scene_);
  mjv_makeScene(model_.get(), &scene_, kMaxGeoms);
  mjv_defaultOption(&options_);
  mjr_defaultContext(&gpu_);
  mjr_makeContext(model_.get(), &gpu_, kFontScale);
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
}

OffscreenRenderer::~OffscreenRenderer() {
  if (context_->MakeCurrent().ok()) mjr_freeContext(&gpu_);
  mjv_freeScene(&scene_);
}

absl::Status OffscreenRenderer::CheckPose(absl::Span<const double> qpos) const {
  if (static_cast<int>(qpos.size()) != model_->nq) {
    return absl::InvalidArgumentError(
        absl::StrCat("rendering: expected a pose of ", model_->nq,
                     " numbers, found ", qpos.size()));
  }
  for (size_t i = 0; i < qpos.size(); ++i) {
    if (!std::isfinite(qpos[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("rendering: expected finite numbers in a pose, found ",
                       qpos[i], " at ", i));
    }
  }
  return absl::OkStatus();
}

void OffscreenRenderer::AddFigure(const Figure& figure, bool first,
                                  mjvCamera* camera) {
  std::copy(figure.qpos.begin(), figure.qpos.end(), data_->qpos);
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
  mj_camlight(model_.get(), data_.get());
  mjvPerturb nothing;
  mjv_defaultPerturb(&nothing);
  const int before = first ? 0 : scene_.ngeom;
  if (first) {
    mjv_updateScene(model_.get(), data_.get(), &options_, &nothing, camera,
                    mjCAT_ALL, &scene_);
  } else {
    mjv_addGeoms(model_.get(), data_.get(), &options_, &nothing, mjCAT_DYNAMIC,
                 &scene_);
  }
  if (first) MoveLamps(*camera, &scene_);
  if (!figure.colour.has_value()) return;
  for (int i = before; i < scene_.ngeom; ++i) {
    mjvGeom& geom = scene_.geoms[i];
    if (geom.category != mjCAT_DYNAMIC) continue;
    std::copy(figure.colour->begin(), figure.colour->end(), geom.rgba);
    geom.matid = -1;
    geom.transparent = geom.rgba[3] < 1;
  }
}

Image OffscreenRenderer::ReadPixels() {
  Image upside_down(width_, height_);
  mjr_readPixels(upside_down.rgb.data(), nullptr, {0, 0, width_, height_},
                 &gpu_);
  Image image(width_, height_);
  const ptrdiff_t stride = ptrdiff_t{3} * width_;
  for (int row = 0; row < height_; ++row) {
    const auto from = upside_down.rgb.begin() + (height_ - 1 - row) * stride;
    std::copy(from, from + stride, image.rgb.begin() + row * stride);
  }
  return image;
}

absl::StatusOr<Image> OffscreenRenderer::Render(
    absl::Span<const Figure> figures, const Camera& camera,
    const std::string& caption) {
  if (figures.empty()) {
    return absl::InvalidArgumentError(
        "rendering: expected at least one figure, found none");
  }
  for (const Figure& figure : figures) {
    SINEW_RETURN_IF_ERROR(CheckPose(figure.qpos));
  }
  SINEW_RETURN_IF_ERROR(context_->MakeCurrent());
  mjvCamera eye = ToMujoco(camera);
  for (size_t i = 0; i < figures.size(); ++i) {
    AddFigure(figures[i], /*first=*/i == 0, &eye);
  }
  const mjrRect frame = {0, 0, width_, height_};
  mjr_render(frame, &scene_, &gpu_);
  if (!caption.empty()) {
    mjr_overlay(mjFONT_NORMAL, mjGRID_TOPLEFT, frame, caption.c_str(), nullptr,
                &gpu_);
  }
  return ReadPixels();
}

}  // namespace sinew::render
