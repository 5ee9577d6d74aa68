#include <algorithm>
#include <cmath>
#include <complex>
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
// the sum being R((k-1) a / 2) c sin(k a / 2) / sin(a / 2). With planes as
// complex numbers, half = exp(i a / 2) and all = exp(i k a / 2) give the rest.
PlanarTransform CycleTransform(const v1::ClipInfo& clip, const float* p0,
                               int64_t cycles) {
  using Complex = std::complex<double>;
  const double a = clip.cycle_yaw();
  const double k = static_cast<double>(cycles);
  const Complex half(std::cos(a / 2), std::sin(a / 2));
  const Complex all(std::cos(k * a / 2), std::sin(k * a / 2));
  const double scale =
      std::abs(half.imag()) < 1e-12 ? k : all.imag() / half.imag();
  const Complex turn = all * all;
  const Complex start(p0[0], p0[1]);
  const Complex shift =
      start - turn * start +
      scale * (all * std::conj(half)) * Complex(clip.cycle_x(), clip.cycle_y());
  return {.cosine = turn.real(),
          .sine = turn.imag(),
          .half_cosine = all.real(),
          .half_sine = all.imag(),
          .x = shift.real(),
          .y = shift.imag()};
}

// Whether cycles move such a column.
bool IsMoved(ColumnKind kind) {
  return kind == ColumnKind::kPosition || kind == ColumnKind::kVelocity ||
         kind == ColumnKind::kRotation;
}

bool IsVelocity(ColumnKind kind) {
  return kind == ColumnKind::kVelocity || kind == ColumnKind::kJointVelocity;
}

void MoveRow(const PlanarTransform& transform, ColumnKind kind, int64_t width,
             const float* in, float* out) {
  if (kind == ColumnKind::kPosition) {
    for (int64_t i = 0; i < width; i += 3) transform.Point(in + i, out + i);
  } else if (kind == ColumnKind::kVelocity) {
    for (int64_t i = 0; i < width; i += 3) transform.Vector(in + i, out + i);
  } else {
    for (int64_t i = 0; i < width; i += 4) transform.Rotation(in + i, out + i);
  }
}

}  // namespace

ReferenceFrame::ReferenceFrame(const Library& library) : library_(&library) {
  int64_t size = 0;
  for (const int64_t width : library.row_widths()) size += width;
  storage_.resize(size);
}

void ReferenceFrame::Load(int clip, int64_t frame) {
  SINEW_DCHECK(frame >= 0) << "frame " << frame;
  if (clip == clip_ && frame == frame_) return;
  clip_ = clip;
  frame_ = frame;
  const v1::ClipInfo& info = library_->clip(clip);
  const int64_t rows = info.num_frames();
  const bool ended = !info.loops() && frame >= rows;
  const int64_t cycles = info.loops() ? frame / rows : 0;
  const int64_t row = info.loops() ? frame % rows : std::min(frame, rows - 1);
  view_ = library_->frame(clip, row);
  if (cycles == 0 && !ended) return;
  PlanarTransform transform;
  if (cycles > 0) {
    transform =
        CycleTransform(info, library_->frame(clip, 0).root_position, cycles);
  }
  float* out = storage_.data();
  const int64_t* width = library_->row_widths().data();
  for (const FrameColumn& column : FrameColumns()) {
    if (ended && IsVelocity(column.kind)) {
      std::fill_n(out, *width, 0.F);
      view_.*column.pointer = out;
    } else if (cycles > 0 && IsMoved(column.kind)) {
      MoveRow(transform, column.kind, *width, view_.*column.pointer, out);
      view_.*column.pointer = out;
    }
    out += *width++;
  }
}

}  // namespace sinew::motion
