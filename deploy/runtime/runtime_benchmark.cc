// Seconds of a tick, for a humanoid: runtime_benchmark [BUNDLE]. Without one it
// writes and runs an untrained bundle (256 x 256, track_clip's observation).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"

namespace sinew::runtime {
namespace {

constexpr int kTicks = 20000;

absl::StatusOr<std::string> UntrainedBundle() {
  const std::string directory =
      (std::filesystem::temp_directory_path() / "sinew_benchmark_bundle")
          .string();
  SINEW_RETURN_IF_ERROR(bundle::WriteBundle(
      bundle::testing::CharacterContent("humanoid", WithDefaults(v1::Recipe())),
      directory));
  return directory;
}

// Microseconds of each tick, sorted.
absl::StatusOr<std::vector<double>> Measure(Runtime& policy, const Pose& state,
                                            const std::vector<Pose>& frames) {
  std::vector<double> target(policy.num_joints()), seconds;
  seconds.reserve(kTicks);
  for (int i = 0; i < kTicks; ++i) {
    const auto start = std::chrono::steady_clock::now();
    SINEW_RETURN_IF_ERROR(policy.StepTo(state, frames, absl::MakeSpan(target)));
    seconds.push_back(std::chrono::duration<double, std::micro>(
                          std::chrono::steady_clock::now() - start)
                          .count());
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds;
}

absl::Status Run(int argc, char** argv) {
  std::string directory = argc > 1 ? argv[1] : "";
  if (directory.empty()) {
    SINEW_ASSIGN_OR_RETURN(directory, UntrainedBundle());
  }
  SINEW_ASSIGN_OR_RETURN(const auto policy, Runtime::Open(directory));
  PoseBuffer buffer(policy->num_joints());
  const std::vector<double> torque(policy->num_joints()),
      contact(policy->reference_needs().feet);
  Pose pose = buffer.pose();
  pose.feedforward_torque = torque.data();
  pose.contact = contact.data();
  const std::vector<Pose> frames(policy->frames().size(), pose);
  for (const bool imu : {false, true}) {
    Pose state = buffer.pose();
    if (imu) state.root_position = state.root_linear_velocity = nullptr;
    SINEW_RETURN_IF_ERROR(policy->Reset(state, &pose));
    SINEW_ASSIGN_OR_RETURN(const std::vector<double> us,
                           Measure(*policy, state, frames));
    std::printf("%s: median %.1f us, p99 %.1f us, p99.9 %.1f us, max %.1f us\n",
                imu ? "IMU alone" : "whole state", us[kTicks / 2],
                us[kTicks * 99 / 100], us[kTicks / 1000 * 999], us.back());
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew::runtime

int main(int argc, char** argv) {
  const absl::Status status = sinew::runtime::Run(argc, argv);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
