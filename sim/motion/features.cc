#include "sim/motion/features.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/check.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/motion/rotation.h"

namespace sinew::motion {
namespace {

// Changes whenever a formula does.
constexpr char kFormula[] = "vmp features, version 1";
// Below this a feature does not move at all: its deviation counts as 1.
constexpr double kLeastDeviation = 1e-5;
constexpr char kFile[] = "vmp.features.safetensors";
// Where theta lies in a row, and the vectors beside it.
constexpr int kTheta = 1;
constexpr int kVelocity = kTheta + 6;
constexpr int kJoints = kVelocity + 6;

using Eigen::Vector3d;

Vector3d ToVector(const float* xyz) { return {xyz[0], xyz[1], xyz[2]}; }

float* Put(const Vector3d& vector, float* out) {
  for (int i = 0; i < 3; ++i) *out++ = static_cast<float>(vector[i]);
  return out;
}

// Columns of the end effectors among the library's bodies.
absl::StatusOr<std::vector<int>> FindBodies(
    const Library& library, const FeatureDefinition& definition) {
  const auto& bodies = library.manifest().bodies();
  std::vector<int> columns;
  std::set<std::string> seen;
  for (const std::string& name : definition.end_effectors) {
    const auto found = std::find(bodies.begin(), bodies.end(), name);
    if (found == bodies.end() || !seen.insert(name).second) {
      return absl::InvalidArgumentError(absl::StrCat(
          "end effectors: expected each body of the library's once (",
          absl::StrJoin(bodies, ", "), "), found \"", name, "\"",
          found == bodies.end() ? "" : " twice"));
    }
    columns.push_back(static_cast<int>(found - bodies.begin()));
  }
  if (columns.empty()) {
    return absl::InvalidArgumentError(
        "end effectors: expected at least one, found none");
  }
  return columns;
}

// One frame seen from its own heading; returns that heading.
double WriteRow(const FrameView& frame, int joints,
                const std::vector<int>& bodies, float* out) {
  const Eigen::Quaterniond rotation =
      FromWxyz(frame.root_rotation).normalized();
  const double yaw = Yaw(rotation);
  const Eigen::Matrix3d to_heading = YawRotation(-yaw).toRotationMatrix();
  const Eigen::Matrix3d theta = to_heading * rotation.toRotationMatrix();
  const Vector3d root = ToVector(frame.root_position);
  *out++ = frame.root_position[2];
  out = Put(theta.col(0), out);
  out = Put(theta.col(1), out);
  out = Put(to_heading * ToVector(frame.root_linear_velocity), out);
  out = Put(to_heading * ToVector(frame.root_angular_velocity), out);
  out = std::copy_n(frame.joint_position, joints, out);
  out = std::copy_n(frame.joint_velocity, joints, out);
  for (const int body : bodies) {
    out = Put(to_heading * (ToVector(frame.body_position + 3 * body) - root),
              out);
  }
  return yaw;
}

// Mean and deviation of the columns of [N, width] rows; theta stays.
void Standardise(absl::Span<const float> rows, int width,
                 absl::Span<float> mean, absl::Span<float> deviation) {
  const double count = static_cast<double>(rows.size()) / width;
  std::vector<double> sum(width), squares(width);
  for (size_t i = 0; i < rows.size(); ++i) sum[i % width] += rows[i];
  for (size_t i = 0; i < rows.size(); ++i) {
    const double off = rows[i] - sum[i % width] / count;
    squares[i % width] += off * off;
  }
  for (int i = 0; i < width; ++i) {
    const bool is_theta = i >= kTheta && i < kVelocity;
    const double spread = std::sqrt(squares[i] / count);
    mean[i] = is_theta ? 0.F : static_cast<float>(sum[i] / count);
    deviation[i] =
        is_theta || spread < kLeastDeviation ? 1.F : static_cast<float>(spread);
  }
}

TensorMap Compute(const Library& library, const std::vector<int>& bodies,
                  int width) {
  const int64_t frames = library.manifest().num_frames();
  TensorMap tensors;
  tensors["frame"] = HostTensor::Zeros({frames, width});
  tensors["heading"] = HostTensor::Zeros({frames});
  tensors["mean"] = HostTensor::Zeros({width});
  tensors["deviation"] = HostTensor::Zeros({width});
  float* row = tensors["frame"].mutable_float32().data();
  float* heading = tensors["heading"].mutable_float32().data();
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    for (int64_t t = 0; t < library.clip(clip).num_frames(); ++t) {
      *heading++ = static_cast<float>(
          WriteRow(library.frame(clip, t), library.num_joints(), bodies, row));
      row += width;
    }
  }
  Standardise(tensors["frame"].float32(), width,
              tensors["mean"].mutable_float32(),
              tensors["deviation"].mutable_float32());
  return tensors;
}

// The stored frame that any frame of a clip repeats.
int64_t WrappedFrame(const v1::ClipInfo& clip, int64_t frame) {
  const int64_t frames = clip.num_frames();
  return clip.loops() ? (frame % frames + frames) % frames
                      : std::clamp<int64_t>(frame, 0, frames - 1);
}

// Turns a vector of a row about z.
void Turn(double cosine, double sine, float* vector) {
  const double x = vector[0];
  const double y = vector[1];
  vector[0] = static_cast<float>(cosine * x - sine * y);
  vector[1] = static_cast<float>(sine * x + cosine * y);
}

}  // namespace

absl::StatusOr<std::unique_ptr<const MotionFeatures>> MotionFeatures::Open(
    const Library& library, const FeatureDefinition& definition,
    const std::string& directory) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<int> bodies,
                         FindBodies(library, definition));
  const int width =
      kJoints + 2 * library.num_joints() + 3 * static_cast<int>(bodies.size());
  const int64_t frames = library.manifest().num_frames();
  const FeatureKey key = {
      .library = &library,
      .definition = absl::StrCat(kFormula, "; ",
                                 absl::StrJoin(definition.end_effectors, " ")),
      .shapes = {{"frame", {frames, width}},
                 {"heading", {frames}},
                 {"mean", {width}},
                 {"deviation", {width}}}};
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<const FeatureFile> file,
      FeatureFile::OpenOrCompute(JoinPath(directory, kFile), key, [&] {
        return Compute(library, bodies, width);
      }));
  return std::unique_ptr<const MotionFeatures>(
      new MotionFeatures(library, width, std::move(file)));
}

MotionFeatures::MotionFeatures(const Library& library, int width,
                               std::unique_ptr<const FeatureFile> file)
    : library_(&library),
      width_(width),
      joints_(library.num_joints()),
      file_(std::move(file)),
      rows_(file_->tensor("frame")),
      headings_(file_->tensor("heading")) {}

double MotionFeatures::Heading(int clip, int64_t frame) const {
  const v1::ClipInfo& info = library_->clip(clip);
  const int64_t row = WrappedFrame(info, frame);
  const double heading = headings_[info.first_frame() + row];
  if (!info.loops()) return heading;
  const auto cycles = static_cast<double>((frame - row) / info.num_frames());
  return heading + cycles * info.cycle_yaw();
}

void MotionFeatures::Row(int clip, int64_t frame, double centre_yaw,
                         float* out) const {
  const v1::ClipInfo& info = library_->clip(clip);
  const int64_t row = WrappedFrame(info, frame);
  std::copy_n(&rows_[(info.first_frame() + row) * width_], width_, out);
  const double turn = Heading(clip, frame) - centre_yaw;
  const double cosine = std::cos(turn);
  const double sine = std::sin(turn);
  for (int i = kTheta; i < kJoints; i += 3) Turn(cosine, sine, out + i);
  for (int i = kJoints + 2 * joints_; i < width_; i += 3) {
    Turn(cosine, sine, out + i);
  }
  const absl::Span<const float> shift = mean();
  const absl::Span<const float> scale = deviation();
  for (int i = 0; i < width_; ++i) out[i] = (out[i] - shift[i]) / scale[i];
}

void MotionFeatures::Window(int clip, int64_t frame, int half,
                            absl::Span<float> out) const {
  SINEW_DCHECK(frame >= 0 && frame < library_->clip(clip).num_frames());
  SINEW_DCHECK(static_cast<int64_t>(out.size()) ==
               int64_t{2 * half + 1} * width_);
  const double centre = Heading(clip, frame);
  for (int64_t i = -half; i <= half; ++i) {
    Row(clip, frame + i, centre, &out[(i + half) * width_]);
  }
}

}  // namespace sinew::motion
