// Prints how well clips play on a character, and how far they are from another
// recording of the same on it:
//   import_figures [--character g1] [--plain] [--against DIR] FILES...
#include <mujoco/mujoco.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "sim/character/character.h"
#include "sim/character/end_effectors.h"
#include "sim/import/clip_name.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/read_clip.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/retarget/role_track.h"
#include "sim/import/retarget/scaled_source.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

absl::StatusOr<Source> Read(const std::string& path, const ImportModel& model) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadFile(path, kMaxClipBytes));
  return ReadClip(path, bytes, ClipName(path), &model, {});
}

absl::StatusOr<Retargeted> Play(const ImportModel& model, const Source& source,
                                const RetargetOptions& options) {
  if (const auto* clip = std::get_if<SourceClip>(&source)) {
    return RetargetClip(model, *clip, options);
  }
  return FitRobotClip(model, std::get<RobotClip>(source), options);
}

constexpr const char* kEnds[] = {"left_wrist", "right_wrist", "left_ankle",
                                 "right_ankle"};

// Mean distance of each of kEnds from the source's, scaled with the legs, both
// seen from the middle of the hips, m; empty: not told.
VectorXd EndsApart(const ImportModel& model, const SourceClip& clip,
                   const Retargeted& played, double rate) {
  const auto roles = LoadSkeletonMap(played.map);
  if (!roles.ok()) return {};
  const auto track =
      MakeRoleTrack(MakeTrack(clip, rate), clip.skeleton, *roles);
  if (!track.ok() || track->frames() != played.motion.frames()) return {};
  const auto map = MakeBodyMap(*track, model);
  if (!map.ok()) return {};
  for (const char* end : kEnds) {
    const int role = track->Find(end);
    if (role < 0 || map->FindPoint(role) < 0) return {};
  }
  Dynamics dynamics(model);
  VectorXd apart = VectorXd::Zero(std::size(kEnds));
  for (int t = 0; t < track->frames(); ++t) {
    dynamics.SetPose(played.motion.qpos[t]);
    const auto ours = [&](const char* role) {
      return PointPlace(*map, map->points[map->FindPoint(track->Find(role))],
                        dynamics);
    };
    const auto source = [&](const char* role) {
      return track->position[t][track->Find(role)];
    };
    const Eigen::Vector3d hips = (ours("left_hip") + ours("right_hip")) / 2;
    const Eigen::Vector3d source_hips =
        (source("left_hip") + source("right_hip")) / 2;
    for (int i = 0; i < apart.size(); ++i) {
      apart[i] += (ours(kEnds[i]) - hips -
                   map->scale * (source(kEnds[i]) - source_hips))
                      .norm() /
                  track->frames();
    }
  }
  return apart;
}

void Print(const std::string& name, const Retargeted& played, double seconds) {
  const v1::ClipQuality& q = played.quality;
  const double duration = played.motion.frames() * played.motion.dt();
  absl::PrintF(
      "%-32.32s %-10.10s %6.2f %5.2f  %.3f %5.1f %5.2f  %6.2f %5.2f %5.2f "
      "%5.2f  %5.2f %5.1f %.2f %.2f\n",
      name, played.map, duration, seconds / duration * 10,
      q.residual_force_bodyweights(), q.residual_torque_nm(),
      q.peak_torque_ratio(), 100 * q.foot_skate_m_per_s(),
      100 * q.foot_penetration_p99_m(), 100 * q.floating_mean_m(),
      100 * q.self_penetration_max_m(), 100 * q.retarget_error_m(),
      100 * q.joint_limit_violation_share(), q.joint_fit_mean_rad(),
      q.airborne_share());
}

// The heading of a frame or, if `whole`, all of its rotation.
Eigen::Matrix3d Orientation(const VectorXd& qpos, bool whole) {
  const Eigen::Quaterniond root = motion::FromWxyz(qpos.data() + 3);
  return (whole ? root : motion::YawRotation(motion::Yaw(root)))
      .toRotationMatrix();
}

// Mean distance of each end of two motions, seen from the root, m.
VectorXd Apart(const ImportModel& model, const std::vector<int>& ends,
               const ModelMotion& a, const ModelMotion& b, bool whole) {
  Dynamics dynamics(model);
  const auto places = [&](const VectorXd& qpos) {
    dynamics.SetPose(qpos);
    const Eigen::Matrix3d frame = Orientation(qpos, whole);
    std::vector<Eigen::Vector3d> result;
    for (const int body : ends) {
      result.push_back(
          frame.transpose() *
          (Eigen::Map<const Eigen::Vector3d>(dynamics.data().xpos + 3 * body) -
           qpos.head<3>()));
    }
    return result;
  };
  const int frames = std::min(a.frames(), b.frames());
  VectorXd apart = VectorXd::Zero(static_cast<Eigen::Index>(ends.size()));
  for (int t = 0; t < frames; ++t) {
    const auto first = places(a.qpos[t]), second = places(b.qpos[t]);
    for (int i = 0; i < apart.size(); ++i) {
      apart[i] += (first[i] - second[i]).norm() / frames;
    }
  }
  return apart;
}

// Mean angle between the roots, rad.
double RootTurn(const ModelMotion& a, const ModelMotion& b) {
  const int frames = std::min(a.frames(), b.frames());
  double sum = 0;
  for (int t = 0; t < frames; ++t) {
    sum += motion::AngleBetween(motion::FromWxyz(a.qpos[t].data() + 3),
                                motion::FromWxyz(b.qpos[t].data() + 3));
  }
  return sum / frames;
}

// `path`: a recording of the same clip on the character. `ends`: body ids.
absl::Status Compare(const ImportModel& model, const std::vector<int>& ends,
                     const std::string& path, const Retargeted& ours,
                     const RetargetOptions& options) {
  RetargetOptions plain = options;
  plain.refine = false;
  SINEW_ASSIGN_OR_RETURN(const Source source, Read(path, model));
  SINEW_ASSIGN_OR_RETURN(const Retargeted theirs, Play(model, source, plain));
  const VectorXd heading =
      Apart(model, ends, ours.motion, theirs.motion, /*whole=*/false);
  absl::PrintF(
      "  apart %.1f cm (whole root rotation: %.1f cm; roots turned %.2f rad); "
      "each: ",
      100 * heading.mean(),
      100 *
          Apart(model, ends, ours.motion, theirs.motion, /*whole=*/true).mean(),
      RootTurn(ours.motion, theirs.motion));
  for (const double end : heading) absl::PrintF("%.1f ", 100 * end);
  absl::PrintF("\n  theirs: skate %.2f cm/s, penetration %.2f cm\n",
               100 * theirs.quality.foot_skate_m_per_s(),
               100 * theirs.quality.foot_penetration_p99_m());
  return absl::OkStatus();
}

absl::StatusOr<std::vector<int>> EndBodies(
    const character::Character& character) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         character::EndEffectors(character));
  std::vector<int> bodies;
  for (const std::string& name : names) {
    bodies.push_back(mj_name2id(character.model(), mjOBJ_BODY, name.c_str()));
  }
  return bodies;
}

struct Flags {
  std::string character = "humanoid";
  std::string against;
  std::vector<std::string> files;
  RetargetOptions options;
};

absl::Status PrintFile(const ImportModel& model, const std::vector<int>& ends,
                       const Flags& flags, const std::string& file) {
  SINEW_ASSIGN_OR_RETURN(const Source source, Read(file, model));
  const double start = ThreadSeconds();
  SINEW_ASSIGN_OR_RETURN(const Retargeted played,
                         Play(model, source, flags.options));
  Print(ClipName(file), played, ThreadSeconds() - start);
  if (const auto* clip = std::get_if<SourceClip>(&source)) {
    const VectorXd apart = EndsApart(model, *clip, played, flags.options.rate);
    if (apart.size() > 0) {
      absl::PrintF("  ends apart from the scaled source: %.1f cm; each: ",
                   100 * apart.mean());
      for (const double end : apart) absl::PrintF("%.1f ", 100 * end);
      absl::PrintF("\n");
    }
  }
  for (const std::string& warning : played.warnings) {
    absl::PrintF("  %s\n", warning);
  }
  if (flags.against.empty()) return absl::OkStatus();
  return Compare(model, ends,
                 JoinPath(flags.against, absl::StrCat(ClipName(file), ".csv")),
                 played, flags.options);
}

absl::Status Run(const Flags& flags) {
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(flags.character, v1::Physics()));
  SINEW_ASSIGN_OR_RETURN(const std::vector<int> ends, EndBodies(*character));
  const ImportModel model = MakeImportModel(*character);
  absl::PrintF(
      "clip                             map             s  s/10s  force torque "
      " peak   skate pen99 float  self  error limit  fit  air\n");
  for (const std::string& file : flags.files) {
    const absl::Status status = PrintFile(model, ends, flags, file);
    if (!status.ok()) absl::PrintF("%s: %s\n", file, status.message());
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew::import

int main(int argc, char** argv) {
  sinew::import::Flags flags;
  bool plain = false;
  CLI::App app("Prints how well clips play on a character");
  app.add_option("--character", flags.character);
  app.add_option("--against", flags.against,
                 "folder with CLIP.csv, the same clips on the character");
  app.add_flag("--plain", plain, "without refinement");
  app.add_option("files", flags.files)->required();
  CLI11_PARSE(app, argc, argv);
  flags.options.refine = !plain;
  const absl::Status status = sinew::import::Run(flags);
  if (!status.ok()) absl::PrintF("%s\n", status.message());
  return status.ok() ? 0 : 2;
}
