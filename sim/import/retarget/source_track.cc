#include "sim/import/retarget/source_track.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/resample.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Keys that the interpolation sees beyond either end of a looping clip.
constexpr int kOverlap = 2;

// A cycle about a place, for whole poses.
struct CycleMotion {
  Vector3d origin;
  Cycle cycle;

  SourcePose Move(SourcePose pose, double period, bool forward) const {
    pose.root_position = cycle.Move(pose.root_position, origin, forward);
    pose.rotation[0] = motion::YawRotation(forward ? cycle.yaw : -cycle.yaw) *
                       pose.rotation[0];
    pose.time += forward ? period : -period;
    return pose;
  }
};

CycleMotion FindCycle(const SourceClip& clip) {
  const SourcePose& first = clip.poses.front();
  const SourcePose& last = clip.poses.back();
  const double yaw =
      motion::Yaw(last.rotation[0] * first.rotation[0].conjugate());
  const Vector3d shift = last.root_position - first.root_position;
  return {.origin = first.root_position,
          .cycle = {.x = shift.x(),
                    .y = shift.y(),
                    .yaw = std::abs(yaw) < kLeastCycleYaw ? 0 : yaw}};
}

// Makes the last pose the first one moved by the cycle.
void CloseLoop(const CycleMotion& cycle, std::vector<SourcePose>* poses) {
  const double period = poses->back().time;
  const SourcePose wanted =
      cycle.Move(poses->front(), period, /*forward=*/true);
  const SourcePose found = poses->back();
  const double rise = found.root_position.z() - wanted.root_position.z();
  for (SourcePose& pose : *poses) {
    const double share = pose.time / period - 0.5;
    pose.root_position.z() -= share * rise;
    for (size_t j = 0; j < pose.rotation.size(); ++j) {
      const Vector3d seam =
          motion::Log(wanted.rotation[j].conjugate() * found.rotation[j]);
      pose.rotation[j] = pose.rotation[j] * motion::Exp(-share * seam);
    }
  }
}

std::vector<SourcePose> Extend(const CycleMotion& cycle,
                               const std::vector<SourcePose>& poses) {
  const double period = poses.back().time;
  const int keys = static_cast<int>(poses.size());
  const int overlap = std::min(kOverlap, keys - 1);
  std::vector<SourcePose> extended;
  for (int i = keys - 1 - overlap; i < keys - 1; ++i) {
    extended.push_back(cycle.Move(poses[i], period, /*forward=*/false));
  }
  extended.insert(extended.end(), poses.begin(), poses.end());
  for (int i = 1; i <= overlap; ++i) {
    extended.push_back(cycle.Move(poses[i], period, /*forward=*/true));
  }
  return extended;
}

// [samples][joints]
std::vector<std::vector<Quaterniond>> SampleRotations(
    const std::vector<SourcePose>& poses, const std::vector<double>& key_times,
    const std::vector<double>& sample_times) {
  const size_t joints = poses[0].rotation.size();
  std::vector<std::vector<Quaterniond>> samples(
      sample_times.size(), std::vector<Quaterniond>(joints));
  for (size_t j = 0; j < joints; ++j) {
    std::vector<Quaterniond> keys;
    for (const SourcePose& pose : poses) keys.push_back(pose.rotation[j]);
    const std::vector<Quaterniond> series =
        motion::ResampleRotations(key_times, keys, sample_times);
    for (size_t t = 0; t < series.size(); ++t) samples[t][j] = series[t];
  }
  return samples;
}

std::vector<double> Times(const std::vector<SourcePose>& poses) {
  std::vector<double> times;
  for (const SourcePose& pose : poses) times.push_back(pose.time);
  return times;
}

}  // namespace

Vector3d Cycle::Move(const Vector3d& place, const Vector3d& pivot,
                     bool forward) const {
  const Vector3d origin(pivot.x(), pivot.y(), 0);
  const Vector3d shift(x, y, 0);
  if (forward) {
    return origin + motion::YawRotation(yaw) * (place - origin) + shift;
  }
  return origin + motion::YawRotation(-yaw) * (place - origin - shift);
}

Cycle MovePivot(const Cycle& cycle, const Vector3d& from, const Vector3d& to) {
  const Vector3d apart = to - from;
  const Vector3d shift = motion::YawRotation(cycle.yaw) * apart - apart;
  return {cycle.x + shift.x(), cycle.y + shift.y(), cycle.yaw};
}

SourceTrack MakeTrack(const SourceClip& clip, double rate) {
  SourceTrack track;
  track.rate = rate;
  track.loops = clip.loops;
  const std::vector<double> samples =
      motion::SampleTimes(clip.duration(), rate, clip.loops);
  track.retiming = (samples[1] - samples[0]) * rate;
  std::vector<SourcePose> poses = clip.poses;
  if (clip.loops) {
    const CycleMotion cycle = FindCycle(clip);
    track.cycle = cycle.cycle;
    CloseLoop(cycle, &poses);
    poses = Extend(cycle, poses);
  }
  track.rotation = SampleRotations(poses, Times(poses), samples);
  std::vector<Vector3d> positions;
  for (const SourcePose& pose : poses) positions.push_back(pose.root_position);
  track.root_position =
      motion::ResampleVectors(Times(poses), positions, samples);
  return track;
}

}  // namespace sinew::import
