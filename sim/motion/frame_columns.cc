#include "sim/motion/frame_columns.h"

namespace sinew::motion {
namespace {

constexpr FrameColumn kColumns[] = {
    {"root_position", &FrameView::root_position, ColumnKind::kPosition,
     ColumnCount::kOne},
    {"root_rotation", &FrameView::root_rotation, ColumnKind::kRotation,
     ColumnCount::kOne},
    {"root_linear_velocity", &FrameView::root_linear_velocity,
     ColumnKind::kVelocity, ColumnCount::kOne},
    {"root_angular_velocity", &FrameView::root_angular_velocity,
     ColumnKind::kVelocity, ColumnCount::kOne},
    {"joint_position", &FrameView::joint_position, ColumnKind::kJoint,
     ColumnCount::kJoints},
    {"joint_velocity", &FrameView::joint_velocity, ColumnKind::kJointVelocity,
     ColumnCount::kJoints},
    {"body_position", &FrameView::body_position, ColumnKind::kPosition,
     ColumnCount::kBodies},
    {"body_rotation", &FrameView::body_rotation, ColumnKind::kRotation,
     ColumnCount::kBodies},
    {"body_linear_velocity", &FrameView::body_linear_velocity,
     ColumnKind::kVelocity, ColumnCount::kBodies},
    {"body_angular_velocity", &FrameView::body_angular_velocity,
     ColumnKind::kVelocity, ColumnCount::kBodies},
    {"contact", &FrameView::contact, ColumnKind::kContact, ColumnCount::kFeet},
    {"feedforward_torque", &FrameView::feedforward_torque, ColumnKind::kJoint,
     ColumnCount::kJoints},
};

int64_t Count(ColumnCount count, const v1::MotionLibrary& manifest) {
  switch (count) {
    case ColumnCount::kOne:
      return 1;
    case ColumnCount::kBodies:
      return manifest.bodies_size();
    case ColumnCount::kJoints:
      return manifest.joints_size();
    case ColumnCount::kFeet:
      return manifest.feet_size();
  }
  return 0;
}

int64_t ElementWidth(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::kPosition:
    case ColumnKind::kVelocity:
      return 3;
    case ColumnKind::kRotation:
      return 4;
    default:
      return 1;
  }
}

}  // namespace

absl::Span<const FrameColumn> FrameColumns() { return kColumns; }

int64_t RowWidth(const FrameColumn& column, const v1::MotionLibrary& manifest) {
  return Count(column.count, manifest) * ElementWidth(column.kind);
}

std::vector<int64_t> ColumnShape(const FrameColumn& column,
                                 const v1::MotionLibrary& manifest,
                                 int64_t rows) {
  std::vector<int64_t> shape = {rows};
  if (column.count != ColumnCount::kOne) {
    shape.push_back(Count(column.count, manifest));
  }
  const int64_t width = ElementWidth(column.kind);
  if (width > 1) shape.push_back(width);
  return shape;
}

}  // namespace sinew::motion
