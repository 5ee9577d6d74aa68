#include "deploy/runtime/sinew_runtime.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "deploy/runtime/runtime.h"

using sinew::runtime::PoseBuffer;
using sinew::runtime::Runtime;

// The opaque handle.
struct sinew_runtime {
  explicit sinew_runtime(std::unique_ptr<Runtime> opened)
      : runtime(std::move(opened)),
        buffer(runtime->num_joints()),
        self_observation(runtime->self_observation_width()) {}

  // 0, or -1 with the error kept.
  int Result(const absl::Status& status) {
    if (status.ok()) return 0;
    error = std::string(status.message());
    return -1;
  }

  const std::unique_ptr<Runtime> runtime;
  PoseBuffer buffer;
  std::vector<float> self_observation;
  std::string error;
};

namespace {

void CopyText(const std::string& text, char* to, size_t size) {
  if (to == nullptr || size == 0) return;
  const size_t count = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), count);
  to[count] = '\0';
}

void Copy(const double* from, int count, double* to) {
  if (to != nullptr) std::copy_n(from, count, to);
}

int Null(sinew_runtime* runtime, const char* what) {
  return runtime->Result(absl::InvalidArgumentError(
      std::string(what) + ": expected a pointer, found NULL"));
}

// Room for `size` numbers; a negative size is none, which no vector has.
template <typename T>
absl::Span<T> Numbers(T* numbers, int size) {
  return {numbers, static_cast<size_t>(std::max(size, 0))};
}

absl::Span<double> Joints(const sinew_runtime* runtime, double* target) {
  return Numbers(target, runtime->runtime->num_joints());
}

absl::Span<const sinew_pose> Frames(const sinew_runtime* runtime,
                                    const sinew_pose* frames) {
  return {frames, runtime->runtime->frames().size()};
}

const sinew::v1::BundleManifest& Manifest(const sinew_runtime* runtime) {
  return runtime->runtime->bundle().manifest;
}

}  // namespace

extern "C" {

sinew_runtime* sinew_open(const char* bundle_directory, char* error,
                          size_t error_size) {
  CopyText("", error, error_size);
  if (bundle_directory == nullptr) {
    CopyText("bundle_directory: expected a path, found NULL", error,
             error_size);
    return nullptr;
  }
  auto opened = Runtime::Open(bundle_directory);
  if (!opened.ok()) {
    CopyText(std::string(opened.status().message()), error, error_size);
    return nullptr;
  }
  return new sinew_runtime(*std::move(opened));
}

void sinew_close(sinew_runtime* runtime) { delete runtime; }

const char* sinew_error(const sinew_runtime* runtime) {
  return runtime->error.c_str();
}

double sinew_control_hz(const sinew_runtime* runtime) {
  return runtime->runtime->control_hz();
}

int sinew_joint_count(const sinew_runtime* runtime) {
  return runtime->runtime->num_joints();
}

const char* sinew_joint_name(const sinew_runtime* runtime, int joint) {
  if (joint < 0 || joint >= Manifest(runtime).joints_size()) return nullptr;
  return Manifest(runtime).joints(joint).name().c_str();
}

void sinew_gains(const sinew_runtime* runtime, double* stiffness,
                 double* damping, double* torque_limit) {
  for (int j = 0; j < Manifest(runtime).joints_size(); ++j) {
    const sinew::v1::BundleJoint& joint = Manifest(runtime).joints(j);
    if (stiffness != nullptr) stiffness[j] = joint.stiffness();
    if (damping != nullptr) damping[j] = joint.damping();
    if (torque_limit != nullptr) torque_limit[j] = joint.torque_limit();
  }
}

int sinew_ramps_target(const sinew_runtime* runtime) {
  return Manifest(runtime).action().ramp() ? 1 : 0;
}

int sinew_foot_count(const sinew_runtime* runtime) {
  return runtime->runtime->reference_needs().feet;
}

int sinew_needs_contact(const sinew_runtime* runtime) {
  return runtime->runtime->reference_needs().contact ? 1 : 0;
}

int sinew_needs_torque(const sinew_runtime* runtime) {
  return runtime->runtime->reference_needs().torque ? 1 : 0;
}

int sinew_load_library(sinew_runtime* runtime, const char* library_directory) {
  if (library_directory == nullptr) return Null(runtime, "library_directory");
  return runtime->Result(runtime->runtime->LoadLibrary(library_directory));
}

int sinew_clip_count(const sinew_runtime* runtime) {
  const auto* library = runtime->runtime->library();
  return library == nullptr ? 0 : library->num_clips();
}

const char* sinew_clip_name(const sinew_runtime* runtime, int clip) {
  if (clip < 0 || clip >= sinew_clip_count(runtime)) return nullptr;
  return runtime->runtime->library()->clip(clip).name().c_str();
}

int sinew_play(sinew_runtime* runtime, const char* clip, double seconds,
               int align) {
  if (clip == nullptr) return Null(runtime, "clip");
  if (align != SINEW_ALIGN_NONE && align != SINEW_ALIGN_TO_BODY) {
    return runtime->Result(absl::InvalidArgumentError(
        "align: expected one of SINEW_ALIGN_..., found " +
        std::to_string(align)));
  }
  return runtime->Result(runtime->runtime->Play(clip, seconds,
                                                align == SINEW_ALIGN_TO_BODY
                                                    ? Runtime::Align::kToBody
                                                    : Runtime::Align::kNone));
}

static_assert(SINEW_AMONG_ALL == static_cast<int>(Runtime::Among::kAll) &&
              SINEW_AMONG_GET_UPS ==
                  static_cast<int>(Runtime::Among::kGetUps) &&
              SINEW_AMONG_UPRIGHT ==
                  static_cast<int>(Runtime::Among::kUpright));

int sinew_play_nearest(sinew_runtime* runtime, const sinew_pose* state,
                       int among, int stand, double* distance) {
  if (state == nullptr) return Null(runtime, "state");
  if (among < SINEW_AMONG_ALL || among > SINEW_AMONG_UPRIGHT) {
    return runtime->Result(absl::InvalidArgumentError(
        "among: expected one of SINEW_AMONG_..., found " +
        std::to_string(among)));
  }
  const absl::StatusOr<double> found = runtime->runtime->PlayNearest(
      *state, static_cast<Runtime::Among>(among), stand);
  if (found.ok()) Copy(&*found, 1, distance);
  return runtime->Result(found.status());
}

int sinew_get_up_steps(const sinew_runtime* runtime) {
  return runtime->runtime->get_up_steps();
}

const char* sinew_clip_playing(const sinew_runtime* runtime) {
  const absl::string_view name = runtime->runtime->clip_name();
  return name.empty() ? nullptr : name.data();  // a string of the library's
}

double sinew_clip_seconds(const sinew_runtime* runtime) {
  return runtime->runtime->clip_seconds();
}

int sinew_seek(sinew_runtime* runtime, double seconds) {
  return runtime->Result(runtime->runtime->Seek(seconds));
}

int sinew_clip_is_over(const sinew_runtime* runtime) {
  return runtime->runtime->is_over() ? 1 : 0;
}

int sinew_reference(sinew_runtime* runtime, int ahead, double* root_position,
                    double* root_rotation, double* root_linear_velocity,
                    double* root_angular_velocity, double* joint_position,
                    double* joint_velocity) {
  const absl::Status status =
      runtime->runtime->ReadReference(ahead, &runtime->buffer);
  if (!status.ok()) return runtime->Result(status);
  const sinew_pose& pose = runtime->buffer.pose();
  const int joints = runtime->runtime->num_joints();
  Copy(pose.root_position, 3, root_position);
  Copy(pose.root_rotation, 4, root_rotation);
  Copy(pose.root_linear_velocity, 3, root_linear_velocity);
  Copy(pose.root_angular_velocity, 3, root_angular_velocity);
  Copy(pose.joint_position, joints, joint_position);
  Copy(pose.joint_velocity, joints, joint_velocity);
  return 0;
}

int sinew_frame_count(const sinew_runtime* runtime) {
  return static_cast<int>(runtime->runtime->frames().size());
}

int sinew_frame_ahead(const sinew_runtime* runtime, int index) {
  if (index < 0 || index >= sinew_frame_count(runtime)) return -1;
  return runtime->runtime->frames()[index];
}

int sinew_reset(sinew_runtime* runtime, const sinew_pose* state,
                const sinew_pose* reference) {
  if (state == nullptr) return Null(runtime, "state");
  return runtime->Result(runtime->runtime->Reset(*state, reference));
}

int sinew_step(sinew_runtime* runtime, const sinew_pose* state,
               double* target) {
  if (state == nullptr) return Null(runtime, "state");
  if (target == nullptr) return Null(runtime, "target");
  return runtime->Result(
      runtime->runtime->Step(*state, Joints(runtime, target)));
}

int sinew_step_to(sinew_runtime* runtime, const sinew_pose* state,
                  const sinew_pose* frames, double* target) {
  if (state == nullptr) return Null(runtime, "state");
  if (frames == nullptr) return Null(runtime, "frames");
  if (target == nullptr) return Null(runtime, "target");
  return runtime->Result(runtime->runtime->StepTo(
      *state, Frames(runtime, frames), Joints(runtime, target)));
}

int sinew_latent_width(const sinew_runtime* runtime) {
  return runtime->runtime->latent_width();
}

int sinew_self_observation_width(const sinew_runtime* runtime) {
  return runtime->runtime->self_observation_width();
}

int sinew_self_observation(sinew_runtime* runtime, const sinew_pose* state,
                           double* observation, int size) {
  if (state == nullptr) return Null(runtime, "state");
  if (observation == nullptr) return Null(runtime, "observation");
  // Of another size it is refused before anything is written.
  const absl::Span<float> room =
      Numbers(runtime->self_observation.data(), size);
  const absl::Status status = runtime->runtime->SelfObservation(*state, room);
  if (status.ok()) std::copy(room.begin(), room.end(), observation);
  return runtime->Result(status);
}

int sinew_encode(sinew_runtime* runtime, const sinew_pose* state,
                 const sinew_pose* frames, double* mean, double* std,
                 int size) {
  if (state == nullptr) return Null(runtime, "state");
  if (mean == nullptr) return Null(runtime, "mean");
  if (std == nullptr) return Null(runtime, "std");
  const absl::Span<double> to_mean = Numbers(mean, size);
  const absl::Span<double> to_std = Numbers(std, size);
  return runtime->Result(
      frames == nullptr
          ? runtime->runtime->Encode(*state, to_mean, to_std)
          : runtime->runtime->EncodeTo(*state, Frames(runtime, frames), to_mean,
                                       to_std));
}

int sinew_prior(sinew_runtime* runtime, const sinew_pose* state, double* mean,
                double* std, int size) {
  if (state == nullptr) return Null(runtime, "state");
  if (mean == nullptr) return Null(runtime, "mean");
  if (std == nullptr) return Null(runtime, "std");
  return runtime->Result(
      runtime->runtime->Prior(*state, Numbers(mean, size), Numbers(std, size)));
}

int sinew_decode(sinew_runtime* runtime, const sinew_pose* state,
                 const double* latent, int size, double* target) {
  if (state == nullptr) return Null(runtime, "state");
  if (latent == nullptr) return Null(runtime, "latent");
  if (target == nullptr) return Null(runtime, "target");
  return runtime->Result(runtime->runtime->Decode(*state, Numbers(latent, size),
                                                  Joints(runtime, target)));
}

int sinew_sample(sinew_runtime* runtime, const sinew_pose* state,
                 const double* noise, int size, double* target) {
  if (state == nullptr) return Null(runtime, "state");
  if (noise == nullptr) return Null(runtime, "noise");
  if (target == nullptr) return Null(runtime, "target");
  return runtime->Result(runtime->runtime->Sample(*state, Numbers(noise, size),
                                                  Joints(runtime, target)));
}

}  // extern "C"
