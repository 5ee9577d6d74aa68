#include "sim/import/testing/amc_play.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/check.h"
#include "common/files.h"
#include "sim/motion/rotation.h"

namespace sinew::import::testing {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAmcRate = 120;
constexpr double kRadians = std::numbers::pi / 180;

double Number(absl::string_view text) {
  double value = 0;
  SINEW_CHECK(absl::SimpleAtod(text, &value)) << text;
  return value;
}

// x to y, y to z, z to x.
Vector3d Turned(double x, double y, double z) { return {z, x, y}; }

// Angles about x, then y, then z of the fixed frame.
Quaterniond Rotation(const double* degrees) {
  Quaterniond rotation = Quaterniond::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = degrees[axis] * kRadians;
    const Vector3d about = angle * Vector3d::Unit(axis);
    rotation = motion::Exp(Turned(about.x(), about.y(), about.z())) * rotation;
  }
  return rotation;
}

void SetBone(const mjModel& model, const std::string& bone,
             const std::vector<double>& angles, VectorXd* qpos) {
  size_t next = 0;
  for (const char* axis : {"x", "y", "z"}) {
    const std::string name = absl::StrCat(bone, "r", axis);
    const int joint = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
    if (joint < 0) continue;
    SINEW_CHECK(next < angles.size()) << bone;
    (*qpos)[model.jnt_qposadr[joint]] = angles[next++] * kRadians;
  }
  SINEW_CHECK(next == angles.size()) << bone << ": " << angles.size();
}

}  // namespace

std::vector<AmcFrame> ReadAmc(const std::string& path) {
  const auto text = ReadFile(path);
  SINEW_CHECK(text.ok()) << text.status();
  std::vector<AmcFrame> frames;
  for (const absl::string_view line :
       absl::StrSplit(*text, absl::ByAnyChar("\r\n"), absl::SkipWhitespace())) {
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    if (absl::StartsWith(words[0], "#") || absl::StartsWith(words[0], ":")) {
      continue;
    }
    if (words.size() == 1) {
      frames.emplace_back();
      continue;
    }
    std::vector<double>& values = frames.back()[std::string(words[0])];
    for (size_t i = 1; i < words.size(); ++i) {
      values.push_back(Number(words[i]));
    }
  }
  return frames;
}

ModelMotion PlayAmc(const character::Character& cmu_humanoid,
                    const std::vector<AmcFrame>& frames,
                    double metres_per_unit) {
  const mjModel& model = *cmu_humanoid.model();
  ModelMotion motion;
  motion.rate = kAmcRate;
  for (const AmcFrame& frame : frames) {
    VectorXd qpos = Eigen::Map<const VectorXd>(model.qpos0, model.nq);
    for (const auto& [bone, values] : frame) {
      if (bone != "root") {
        SetBone(model, bone, values, &qpos);
        continue;
      }
      SINEW_CHECK(values.size() == 6) << values.size();
      qpos.head<3>() =
          metres_per_unit * Turned(values[0], values[1], values[2]);
      motion::ToWxyz(Rotation(&values[3]), qpos.data() + 3);
    }
    motion.qpos.push_back(qpos);
  }
  return motion;
}

}  // namespace sinew::import::testing
