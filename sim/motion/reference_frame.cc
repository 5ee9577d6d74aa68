#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/check.h"
#include "sim/motion/frame_columns.h"
#include "sim/motion/library.h"

namespace sinew::motion {
namespace {

// A turn about world z through the origin, then a shift along the floor.
struct PlanarTransform {
  double cosine = 1, sine = 0;
  double half_cosine = 1, half_sine = 0;  // of the turn's quaternion
  double x = 0, y = 0;

  void Point(const float* in, float* out) const {
    const double px = in[0];
    const double py = in[1];
    out[0] = static_cast<float>(x + cosine * px - sine * py);
    out[1] = static_cast<float>(y + sine * px + cosine * py);
    out[2] = in[2];
  }
  void Vector(const float* in, float* out) const {
    const double vx = in[0];
    const double vy = in[1];
    out[0] = static_cast<float>(cosine * vx - sine * vy);
    out[1] = static_cast<float>(sine * vx + cosine * vy);
    out[2] = in[2];
  }
  // (cos, 0, 0, sin) of the half turn times q.
  void Rotation(const float* q, float* out) const {
    const double w = q[0], qx = q[1], qy = q[2], qz = q[3];
    out[0] = static_cast<float>(half_cosine * w - half_sine * qz);
    out[1] = static_cast<float>(half_cosine * qx - half_sine * qy);
    out[2] = static_cast<float>(half_cosine * qy + half_sine * qx);
    out[3] = static_cast<float>(half_cosine * qz + half_sine * w);
  }
};

// The cycle transform of `clip` applied `cycles` times: with a = cycle_yaw,
// c = cycle_x,y and p0 the root's place in the first row,
//   x -> p0 + R(k a)(x - p0) + sum over j < k of R(j a) c,
// the sum being R((k-1) a / 2) c sin(k a / 2) / sin(a / 2).
PlanarTransform CycleTransform(const v1::ClipInfo& clip, const float* p0,
                               int64_t cycles) {
  const double a = clip.cycle_yaw();
  const double k = static_cast<double>(cycles);
  const double half = std::sin(a / 2);
  const double scale =
      std::abs(half) < 1e-12 ? k : std::sin(k * a / 2) / half;
  const double middle = (k - 1) * a / 2;
  PlanarTransform t;
  t.cosine = std::cos(k * a);
  t.sine = std::sin(k * a);
  t.half_cosine = std::cos(k * a / 2);
  t.half_sine = std::sin(k * a / 2);
  const double cx = scale * (std::cos(middle) * clip.cycle_x() -
                             std::sin(middle) * clip.cycle_y());
  const double cy = scale * (std::sin(middle) * clip.cycle_x() +
                             std::cos(middle) * clip.cycle_y());
  t.x = p0[0] + cx - (t.cosine * p0[0] - t.sine * p0[1]);
  t.y = p0[1] + cy - (t.sine * p0[0] + t.cosine * p0[1]);
  return t;
}

void MoveRow(const PlanarTransform& transform, ColumnKind kind, int64_t width,
             const float* in, float* out) {
  switch (kind) {
    case ColumnKind::kPosition:
      for (int64_t i = 0; i < width; i += 3) transform.Point(in + i, out + i);
      break;
    case ColumnKind::kVelocity:
      for (int64_t i = 0; i < width; i += 3) transform.Vector(in + i, out + i);
      break;
    case ColumnKind::kRotation:
      for (int64_t i = 0; i < width; i += 4) {
        transform.Rotation(in + i, out + i);
      }
      break;
    default:
      std::copy_n(in, width, out);
  }
}

}  // namespace

ReferenceFrame::ReferenceFrame(const Library& library) {
  int64_t size = 0;
  for (const FrameColumn& column : FrameColumns()) {
    size += RowWidth(column, library.manifest());
  }
  storage_.resize(size);
  const float* next = storage_.data();
  for (const FrameColumn& column : FrameColumns()) {
    view_.*column.pointer = next;
    next += RowWidth(column, library.manifest());
  }
}

void ReferenceFrame::Load(const Library& library, int clip, int64_t frame) {
  SINEW_DCHECK(frame >= 0) << "frame " << frame;
  const v1::ClipInfo& info = library.clip(clip);
  const int64_t rows = info.num_frames();
  const bool ended = !info.loops() && frame >= rows;
  const int64_t cycles = info.loops() ? frame / rows : 0;
  const int64_t row = info.loops() ? frame % rows : std::min(frame, rows - 1);
  const FrameView source = library.frame(clip, row);
  PlanarTransform transform;
  if (cycles > 0) {
    transform =
        CycleTransform(info, library.frame(clip, 0).root_position, cycles);
  }
  float* out = storage_.data();
  for (const FrameColumn& column : FrameColumns()) {
    const int64_t width = RowWidth(column, library.manifest());
    const bool is_velocity = column.kind == ColumnKind::kVelocity ||
                             column.kind == ColumnKind::kJointVelocity;
    if (ended && is_velocity) {
      std::fill_n(out, width, 0.F);
    } else {
      MoveRow(transform, column.kind, width, source.*column.pointer, out);
    }
    out += width;
  }
}

}  // namespace sinew::motion
