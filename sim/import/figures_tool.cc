// Prints how well clips play on a character:
//   figures_tool [--character g1] [--plain] [--against DIR] [--dump DIR]
//   FILES...
// --plain: without refinement. --against: for a file with a recording of the
// same clip on the character (DIR/STEM.csv) how far the two are apart. --dump:
// writes the places of all joints to DIR/STEM.txt.
#include <algorithm>
#include <ctime>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/bvh.h"
#include "sim/import/formats/deepmimic.h"
#include "sim/import/formats/robot_csv.h"
#include "sim/import/formats/robot_layout.h"
#include "sim/import/formats/smpl_npz.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/retarget/body_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"
#include "sim/import/retarget/role_track.h"
#include "sim/import/retarget/scaled_source.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

constexpr int64_t kMaxBytes = int64_t{1} << 30;

std::string Stem(const std::string& path) {
  const std::string base = path.substr(path.rfind('/') + 1);
  return base.substr(0, base.rfind('.'));
}

absl::StatusOr<Source> Read(const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMaxBytes));
  const std::string name = Stem(path);
  if (absl::EndsWith(path, ".bvh")) return ParseBvh(bytes, name, path, {});
  if (absl::EndsWith(path, ".npz")) return ParseSmplNpz(bytes, name, path, {});
  if (absl::EndsWith(path, ".txt")) return ParseDeepMimic(bytes, name, path);
  if (absl::EndsWith(path, ".amc")) {
    for (const std::string& asf : AsfCandidates(path)) {
      SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(asf, kMaxBytes));
      SINEW_ASSIGN_OR_RETURN(const AsfSkeleton skeleton, ParseAsf(text, asf));
      return ParseAmc(bytes, skeleton, name, path, {});
    }
  }
  return absl::InvalidArgumentError(absl::StrCat(path, ": unknown format"));
}

absl::StatusOr<Retargeted> Play(const ImportModel& model, const Source& source,
                                const RetargetOptions& options) {
  if (const auto* clip = std::get_if<SourceClip>(&source)) {
    return RetargetClip(model, *clip, options);
  }
  return FitRobotClip(model, std::get<RobotClip>(source), options);
}

// Mean distance of hands and feet from the source's, scaled with the
// legs, both seen from the middle of the hips, m.
double EndsApart(const ImportModel& model, const SourceClip& clip,
                 const Retargeted& played, double rate) {
  const auto roles = LoadSkeletonMap(played.map);
  if (!roles.ok()) return 0;
  const auto track =
      MakeRoleTrack(MakeTrack(clip, rate), clip.skeleton, *roles);
  if (!track.ok() || track->frames() != played.motion.frames()) return 0;
  const auto map = MakeBodyMap(*track, model);
  if (!map.ok()) return 0;
  Dynamics dynamics(model);
  double sum = 0;
  int count = 0;
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
    for (const char* end :
         {"left_wrist", "right_wrist", "left_ankle", "right_ankle"}) {
      const int role = track->Find(end);
      if (role < 0 || map->FindPoint(role) < 0) continue;
      sum +=
          (ours(end) - hips - map->scale * (source(end) - source_hips)).norm();
      ++count;
    }
  }
  return count == 0 ? 0 : sum / count;
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
Eigen::Matrix3d Orientation(const Eigen::VectorXd& qpos, bool whole) {
  const Eigen::Quaterniond root = motion::FromWxyz(qpos.data() + 3);
  return (whole ? root : motion::YawRotation(motion::Yaw(root)))
      .toRotationMatrix();
}

// Bodies of the feet, then of the hands.
std::vector<int> Ends(const ImportModel& model) {
  std::vector<int> ends = model.feet;
  for (const char* side : {"left_wrist", "right_wrist"}) {
    int hand = 0;
    for (const SemanticJoint& joint : model.semantics) {
      if (!absl::StartsWith(joint.semantic, side)) continue;
      hand = std::max(hand, model.model->jnt_bodyid[joint.joint]);
    }
    if (hand > 0) ends.push_back(hand);
  }
  return ends;
}

// Mean distance of each end of two motions, seen from the root, m.
std::vector<double> Apart(const ImportModel& model, const ModelMotion& a,
                          const ModelMotion& b, bool whole) {
  Dynamics dynamics(model);
  const std::vector<int> ends = Ends(model);
  const auto places = [&](const Eigen::VectorXd& qpos) {
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
  std::vector<double> sums(ends.size(), 0);
  for (int t = 0; t < frames; ++t) {
    const auto first = places(a.qpos[t]), second = places(b.qpos[t]);
    for (size_t i = 0; i < ends.size(); ++i) {
      sums[i] += (first[i] - second[i]).norm() / frames;
    }
  }
  return sums;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
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

void Compare(const ImportModel& model, const std::string& path,
             const Retargeted& ours, const RetargetOptions& options) {
  const auto bytes = ReadFile(path, kMaxBytes);
  const auto layouts = KnownRobotLayouts();
  if (!bytes.ok() || !layouts.ok()) return;
  ReadOptions read;
  read.quaternion_order = "xyzw";
  const auto clip = ParseRobotCsv(*bytes, Stem(path), path, read, *layouts);
  if (!clip.ok()) {
    absl::PrintF("  %s\n", clip.status().message());
    return;
  }
  RetargetOptions plain = options;
  plain.refine = false;
  const auto theirs = FitRobotClip(model, *clip, plain);
  if (!theirs.ok()) {
    absl::PrintF("  %s\n", theirs.status().message());
    return;
  }
  const auto heading = Apart(model, ours.motion, theirs->motion, false);
  absl::PrintF(
      "  apart %.1f cm (whole root rotation: %.1f cm; roots turned %.2f rad); "
      "each: ",
      100 * Mean(heading),
      100 * Mean(Apart(model, ours.motion, theirs->motion, true)),
      RootTurn(ours.motion, theirs->motion));
  for (const double end : heading) absl::PrintF("%.1f ", 100 * end);
  absl::PrintF("\n  theirs: skate %.2f cm/s, penetration %.2f cm\n",
               100 * theirs->quality.foot_skate_m_per_s(),
               100 * theirs->quality.foot_penetration_p99_m());
}

// Parents of the bodies, of the source's joints, then a frame a line: places.
void Dump(const ImportModel& model, const Retargeted& played,
          const std::string& path) {
  Dynamics dynamics(model);
  const int bodies = model.model->nbody;
  std::vector<int> parents(model.model->body_parentid,
                           model.model->body_parentid + bodies);
  std::string text =
      absl::StrCat(absl::StrJoin(parents, " "), "\n",
                   absl::StrJoin(played.source_parents, " "), "\n");
  for (int t = 0; t < played.motion.frames(); ++t) {
    dynamics.SetPose(played.motion.qpos[t]);
    const double* xpos = dynamics.data().xpos;
    const std::vector<double> places(xpos, xpos + 3 * bodies);
    absl::StrAppend(&text, absl::StrJoin(places, " "));
    if (!played.source_joints.empty()) {
      for (const Eigen::Vector3d& p : played.source_joints[t]) {
        absl::StrAppend(&text, " ", p.x(), " ", p.y(), " ", p.z());
      }
    }
    text += "\n";
  }
  const absl::Status status = WriteFileAtomically(path, text);
  if (!status.ok()) absl::PrintF("%s\n", status.message());
}

int Main(int argc, char** argv) {
  std::string character = "humanoid", against, dump;
  std::vector<std::string> files;
  RetargetOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    const bool has_value = i + 1 < argc;
    if (flag == "--plain") {
      options.refine = false;
    } else if (flag == "--character" && has_value) {
      character = argv[++i];
    } else if (flag == "--against" && has_value) {
      against = argv[++i];
    } else if (flag == "--dump" && has_value) {
      dump = argv[++i];
    } else if (absl::StartsWith(flag, "--")) {
      absl::PrintF("unknown flag %s\n", flag);
      return 2;
    } else {
      files.push_back(flag);
    }
  }
  const auto body = character::Character::Load(character, v1::Physics());
  if (!body.ok()) {
    absl::PrintF("%s\n", body.status().message());
    return 2;
  }
  const ImportModel model = MakeImportModel(**body);
  absl::PrintF(
      "clip                             map             s  s/10s  force torque "
      " peak   skate pen99 float  self  error limit  fit  air\n");
  for (const std::string& file : files) {
    const auto source = Read(file);
    const std::clock_t start = std::clock();
    const absl::StatusOr<Retargeted> played =
        source.ok() ? Play(model, *source, options)
                    : absl::StatusOr<Retargeted>(source.status());
    const double took = static_cast<double>(std::clock() - start) /
                        static_cast<double>(CLOCKS_PER_SEC);
    if (!played.ok()) {
      absl::PrintF("%s: %s\n", file, played.status().message());
      continue;
    }
    Print(Stem(file), *played, took);
    if (const auto* clip = std::get_if<SourceClip>(&*source)) {
      absl::PrintF("  ends apart from the scaled source: %.1f cm\n",
                   100 * EndsApart(model, *clip, *played, options.rate));
    }
    if (!dump.empty()) {
      Dump(model, *played, JoinPath(dump, absl::StrCat(Stem(file), ".txt")));
    }
    for (const std::string& warning : played->warnings) {
      absl::PrintF("  %s\n", warning);
    }
    if (against.empty()) continue;
    Compare(model, JoinPath(against, absl::StrCat(Stem(file), ".csv")), *played,
            options);
  }
  return 0;
}

}  // namespace
}  // namespace sinew::import

int main(int argc, char** argv) { return sinew::import::Main(argc, argv); }
