#ifndef SINEW_SIM_MOTION_FRAME_COLUMNS_H_
#define SINEW_SIM_MOTION_FRAME_COLUMNS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "sim/motion/library.h"

namespace sinew::motion {

// What a frame tensor holds, as far as moving and checking it is concerned.
enum class ColumnKind {
  kPosition,       // points in the world, [.., 3]
  kRotation,       // unit quaternions wxyz, [.., 4]
  kVelocity,       // world vectors, [.., 3]; zero once a clip has ended
  kJoint,          // [J], no frame
  kJointVelocity,  // [J]; zero once a clip has ended
  kContact,        // [F], 0 to 1
};

// How many of them a frame has.
enum class ColumnCount { kOne, kBodies, kJoints, kFeet };

// One frame tensor of a library; the table is the single list of them.
struct FrameColumn {
  const char* name;
  const float* FrameView::* pointer;
  ColumnKind kind;
  ColumnCount count;
};

// All frame tensors, in the order of FrameView.
absl::Span<const FrameColumn> FrameColumns();

// Elements in a row of `column`.
int64_t RowWidth(const FrameColumn& column, const v1::MotionLibrary& manifest);

// Shape of the tensor for `rows` rows.
std::vector<int64_t> ColumnShape(const FrameColumn& column,
                                 const v1::MotionLibrary& manifest,
                                 int64_t rows);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_FRAME_COLUMNS_H_
