#include "sim/import/formats/quaternion_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/check.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kMaxFrames = 200;
constexpr double kMaxHeight = 1;  // m
constexpr double kMaxSkate = 5;   // m/s

constexpr char kWxyz[] = "wxyz";
constexpr char kXyzw[] = "xyzw";

// Columns that were read as w, x, y, z, in the order that they are in.
Quaterniond Reorder(const Quaterniond& read, const std::string& order) {
  if (order == kWxyz) return read;
  return Quaterniond(read.z(), read.w(), read.x(), read.y());
}

// Where the coordinates of a clip go in the model's qpos.
struct Addresses {
  int root = 0;
  // [clip's joints]; -1: the model has none of that name.
  std::vector<int> joints;
};

absl::StatusOr<Addresses> FindAddresses(const RobotClip& clip,
                                        const mjModel& model) {
  Addresses addresses;
  addresses.root = -1;
  for (int i = 0; i < model.njnt; ++i) {
    if (model.jnt_type[i] == mjJNT_FREE) addresses.root = model.jnt_qposadr[i];
  }
  bool any = false;
  for (const std::string& name : clip.joints) {
    const int joint = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
    addresses.joints.push_back(joint < 0 ? -1 : model.jnt_qposadr[joint]);
    any = any || joint >= 0;
  }
  if (addresses.root < 0 || !any) {
    return absl::InvalidArgumentError(absl::StrCat(
        clip.name, ": quaternion order: expected a model with a free joint ",
        "and joints of the clip (", clip.joints.empty() ? "" : clip.joints[0],
        " ...), found ", addresses.root < 0 ? "no free joint" : "none"));
  }
  return addresses;
}

void SetPose(const RobotPose& pose, const std::string& order,
             const Addresses& addresses, const mjModel& model, mjData* data) {
  mju_copy(data->qpos, model.qpos0, model.nq);
  mju_copy3(data->qpos + addresses.root, pose.root_position.data());
  motion::ToWxyz(Reorder(pose.root_rotation, order),
                 data->qpos + addresses.root + 3);
  for (size_t i = 0; i < addresses.joints.size(); ++i) {
    if (addresses.joints[i] >= 0) {
      data->qpos[addresses.joints[i]] = pose.joints[i];
    }
  }
  mj_kinematics(&model, data);
}

// Height of the lowest corner of a geom's box.
double LowestOf(const mjModel& model, const mjData& data, int geom) {
  const mjtNum* box = model.geom_aabb + 6 * geom;  // centre, half sizes
  const mjtNum* z_row = data.geom_xmat + 9 * geom + 6;
  double lowest = data.geom_xpos[3 * geom + 2];
  for (int i = 0; i < 3; ++i) {
    lowest += z_row[i] * box[i] - std::abs(z_row[i]) * box[3 + i];
  }
  return lowest;
}

// The lowest point of what moves, and the body that it is of.
struct Lowest {
  double height = std::numeric_limits<double>::infinity();
  int body = 0;
};

Lowest FindLowest(const mjModel& model, const mjData& data) {
  Lowest lowest;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (model.body_weldid[body] == 0) continue;
    const double height = LowestOf(model, data, geom);
    if (height < lowest.height) lowest = {.height = height, .body = body};
  }
  for (int body = 1; lowest.body == 0 && body < model.nbody; ++body) {
    // A model without shapes.
    const double height = data.xpos[3 * body + 2];
    if (height < lowest.height) lowest = {.height = height, .body = body};
  }
  return lowest;
}

OrderEvidence Weigh(const RobotClip& clip, const std::string& order,
                    const Addresses& addresses, const mjModel& model,
                    mjData* data) {
  OrderEvidence evidence;
  const int last = static_cast<int>(clip.poses.size()) - 1;
  const int frames = std::min(last, kMaxFrames);
  for (int i = 0; i < frames; ++i) {
    const int frame = static_cast<int>(int64_t{last} * i / frames);
    const RobotPose& pose = clip.poses[frame];
    const RobotPose& next = clip.poses[frame + 1];
    SetPose(pose, order, addresses, model, data);
    const Lowest lowest = FindLowest(model, *data);
    const Vector3d before(data->xpos + 3 * lowest.body);
    const Vector3d up = Reorder(pose.root_rotation, order) * Vector3d::UnitZ();
    SetPose(next, order, addresses, model, data);
    const Vector3d moved = Vector3d(data->xpos + 3 * lowest.body) - before;
    evidence.height_m += std::min(std::abs(lowest.height), kMaxHeight);
    evidence.skate_m_per_s +=
        std::min(moved.head<2>().norm() / (next.time - pose.time), kMaxSkate);
    evidence.lean += 1 - up.z();
  }
  evidence.height_m /= frames;
  evidence.skate_m_per_s /= frames;
  evidence.lean /= frames;
  return evidence;
}

// Reads the rotations of a clip whose order was unknown in that order.
void SetQuaternionOrder(const std::string& order, RobotClip* clip) {
  for (RobotPose& pose : clip->poses) {
    pose.root_rotation = Reorder(pose.root_rotation, order);
  }
  clip->facts.set_quaternion_order(order);
}

}  // namespace

bool OrderConclusion::is_doubtful() const {
  const double better = std::min(wxyz.score(), xyzw.score());
  const double worse = std::max(wxyz.score(), xyzw.score());
  return worse < 2 * better;
}

absl::StatusOr<OrderConclusion> CompareQuaternionOrders(const RobotClip& clip,
                                                        const mjModel& model) {
  SINEW_CHECK(clip.facts.quaternion_order().empty() && clip.poses.size() > 1);
  SINEW_ASSIGN_OR_RETURN(const Addresses addresses, FindAddresses(clip, model));
  const character::DataPtr data(mj_makeData(&model));
  OrderConclusion conclusion;
  conclusion.wxyz = Weigh(clip, kWxyz, addresses, model, data.get());
  conclusion.xyzw = Weigh(clip, kXyzw, addresses, model, data.get());
  return conclusion;
}

absl::Status SettleQuaternionOrder(const mjModel& model, RobotClip* clip) {
  if (!clip->facts.quaternion_order().empty()) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const OrderConclusion conclusion,
                         CompareQuaternionOrders(*clip, model));
  SetQuaternionOrder(conclusion.order(), clip);
  clip->facts.add_concluded("quaternion_order");
  if (conclusion.is_doubtful()) {
    clip->warnings.push_back(absl::StrFormat(
        "quaternions are read as %s, but the other order fits nearly as well "
        "(%.2f against %.2f)",
        conclusion.order(),
        std::min(conclusion.wxyz.score(), conclusion.xyzw.score()),
        std::max(conclusion.wxyz.score(), conclusion.xyzw.score())));
  }
  return absl::OkStatus();
}

}  // namespace sinew::import
