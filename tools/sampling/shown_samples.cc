#include "tools/sampling/shown_samples.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/build_info.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/import/import_clip.h"
#include "tools/motion_report/body_shapes.h"
#include "tools/motion_report/page.h"
#include "tools/motion_report/trajectory.h"
#include "tools/render/film_strip.h"
#include "tools/render/image.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::sampling {
namespace {

using Json = nlohmann::json;

constexpr int kColumns = 8;
constexpr int kWidth = 240, kHeight = 360;

absl::Status WriteStrip(render::OffscreenRenderer& renderer,
                        const render::PoseRows& rows, double rate,
                        const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(
      const render::Image strip,
      render::ReferenceStrip(renderer, rows, kColumns, rate));
  SINEW_ASSIGN_OR_RETURN(const std::string png, render::EncodePng(strip));
  return WriteFileAtomically(path, png);
}

// Positions and rotations of all bodies but the world, as a library has them.
TensorMap BodyFrames(const mjModel* model, const std::vector<double>& qpos) {
  const character::DataPtr data(mj_makeData(model));
  const int64_t frames = static_cast<int64_t>(qpos.size()) / model->nq;
  const int64_t bodies = model->nbody - 1;
  std::vector<float> position, rotation;
  for (int64_t frame = 0; frame < frames; ++frame) {
    std::copy_n(qpos.begin() + frame * model->nq, model->nq, data->qpos);
    mj_kinematics(model, data.get());
    position.insert(position.end(), data->xpos + 3,
                    data->xpos + 3 * model->nbody);
    rotation.insert(rotation.end(), data->xquat + 4,
                    data->xquat + 4 * model->nbody);
  }
  TensorMap tensors;
  tensors["body_position"] = HostTensor::Float32({frames, bodies, 3}, position);
  tensors["body_rotation"] = HostTensor::Float32({frames, bodies, 4}, rotation);
  return tensors;
}

Json Known(double value, bool known = true) {
  return known && std::isfinite(value) ? Json(value) : Json(nullptr);
}

// The columns of the page's table.
Json WayObject(const SampleFigures& one) {
  const bool compared = one.transitions.has_value();
  return {
      {"name", one.name},
      {"samples", one.samples},
      {"upright_percent", Known(100 * one.upright_share)},
      {"got_up_percent", Known(100 * one.got_up_share)},
      {"stuck_percent", Known(100 * one.stuck_share)},
      {"diversity_m",
       Known(one.diversity.over_time_m, one.diversity.pairs > 0)},
      {"coverage_percent",
       Known(compared ? 100 * one.transitions->coverage : 0, compared)},
      {"distance", Known(compared ? one.transitions->distance : 0, compared)},
      {"foot_skate_cm_per_s",
       Known(100 * one.skate.mean_m_per_s(), one.skate.contacts > 0)},
      {"root_speed_m_per_s", Known(one.energy.root_speed_m_per_s())},
      {"starts", Json::array()},
      {"trajectories", Json::array()}};
}

}  // namespace

absl::StatusOr<std::vector<std::string>> WritePictures(
    const character::Character& character, double frames_per_second,
    const std::vector<ShownWay>& ways, const std::string& folder,
    const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  SINEW_ASSIGN_OR_RETURN(const auto renderer,
                         render::OffscreenRenderer::Create(
                             render::PictureModel(character), kWidth, kHeight));
  std::vector<std::string> paths;
  for (const ShownWay& way : ways) {
    const std::string stem = absl::StrReplaceAll(way.name, {{" ", "_"}});
    for (size_t i = 0; i < way.samples.size(); ++i) {
      if (stop.stop_requested()) {
        return absl::CancelledError("pictures: stopped before the end");
      }
      const std::string path =
          JoinPath(folder, absl::StrCat(stem, "-", i, ".png"));
      SINEW_RETURN_IF_ERROR(WriteStrip(
          *renderer,
          {way.samples[i].qpos, static_cast<int>(character.model()->nq)},
          frames_per_second, path));
      paths.push_back(path);
    }
  }
  return paths;
}

absl::StatusOr<std::string> SamplesPage(
    const character::Character& character, const SamplingSource& source,
    const std::vector<SampleFigures>& figures,
    const std::vector<ShownWay>& ways) {
  Json report = {{"samples", true},
                 {"bundle", source.bundle},
                 {"character", source.character},
                 {"start", source.start},
                 {"seconds", source.seconds},
                 {"seed", source.seed},
                 {"build", BuildIdentity()},
                 {"bodies", motion_report::BodyShapes(*character.model())},
                 {"ways", Json::array()}};
  std::vector<motion_report::Trajectory> trajectories;
  for (const SampleFigures& one : figures) {
    Json object = WayObject(one);
    for (const ShownWay& way : ways) {
      if (way.name != one.name) continue;
      for (const ShownWay::Sample& sample : way.samples) {
        SINEW_ASSIGN_OR_RETURN(motion_report::Trajectory trajectory,
                               motion_report::MakeTrajectory(
                                   BodyFrames(character.model(), sample.qpos),
                                   source.control_hz, import::SourcePreview()));
        object["starts"].push_back(sample.start);
        object["trajectories"].push_back(trajectories.size());
        trajectories.push_back(std::move(trajectory));
      }
    }
    report["ways"].push_back(std::move(object));
  }
  return motion_report::MakePage(report, trajectories);
}

}  // namespace sinew::sampling
