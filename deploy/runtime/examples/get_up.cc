// Falls in MuJoCo and gets up: get_up BUNDLE LIBRARY [FALLS].
//
// LIBRARY has get-ups, clips from the floor to standing, and clips that stay
// upright; BUNDLE is of a policy that has learnt to follow both.
#include <cstdio>
#include <cstdlib>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"
#include "sim/world/fallen_states.h"
#include "sim/world/get_up_frames.h"

namespace {

using sinew::runtime::PoseBuffer;
using sinew::runtime::Runtime;
using sinew::runtime::Simulation;

constexpr double kSeconds = 5.5;  // for one fall
// Farther off its reference than this, m, a body has fallen.
constexpr double kFallen = 0.5;

// Shows the policy what to do next, whenever that is to be said.
class Guide {
 public:
  explicit Guide(Runtime* policy)
      : policy_(*policy),
        low_(sinew::world::UprightRootHeight(policy->character())),
        next_(policy->num_joints()) {}

  // The body lies.
  absl::Status Fell(const sinew::runtime::Pose& body) {
    is_up_ = false;
    return policy_
        .PlayNearest(body, Runtime::Among::kGetUps, policy_.get_up_steps())
        .status();
  }

  // Before each step.
  absl::Status Look(const sinew::runtime::Pose& body) {
    SINEW_RETURN_IF_ERROR(policy_.ReadReference(/*ahead=*/1, &next_));
    const bool leads_down = is_up_ && next_.pose().root_position[2] < low_;
    if (!policy_.is_over() && !leads_down) return absl::OkStatus();
    SINEW_ASSIGN_OR_RETURN(
        const double distance,
        policy_.PlayNearest(body, Runtime::Among::kUpright, /*stand=*/0));
    is_up_ = true;
    return distance > kFallen ? Fell(body) : absl::OkStatus();
  }

 private:
  Runtime& policy_;
  const double low_;  // root, m
  PoseBuffer next_;
  bool is_up_ = false;
};

// Whether the body is up at the end.
absl::StatusOr<bool> GetUp(Runtime& policy, Simulation& body) {
  Guide guide(&policy);
  SINEW_RETURN_IF_ERROR(guide.Fell(body.pose()));
  SINEW_RETURN_IF_ERROR(policy.Reset(body.pose(), /*reference=*/nullptr));
  for (int step = 0; step < kSeconds * policy.control_hz(); ++step) {
    SINEW_RETURN_IF_ERROR(guide.Look(body.pose()));
    SINEW_RETURN_IF_ERROR(policy.Step(body.pose(), body.target()));
    SINEW_RETURN_IF_ERROR(body.Step());
  }
  return body.pose().root_position[2] >=
         sinew::world::UprightRootHeight(policy.character());
}

absl::Status Run(const char* bundle, const char* library, int falls) {
  SINEW_ASSIGN_OR_RETURN(const auto policy, Runtime::Open(bundle));
  SINEW_RETURN_IF_ERROR(policy->LoadLibrary(library));
  SINEW_ASSIGN_OR_RETURN(
      const auto fallen,
      sinew::world::FallenStates::MakeForEvaluation(
          policy->character(),
          sinew::bundle::TaskRecipe(policy->bundle().manifest), falls));
  Simulation body(*policy);
  int up = 0;
  for (int fall = 0; fall < falls; ++fall) {
    body.Place(fallen.qpos(fall));
    SINEW_ASSIGN_OR_RETURN(const bool is_up, GetUp(*policy, body));
    up += is_up ? 1 : 0;
  }
  std::printf("%d of %d up after %.1f s\n", up, falls, kSeconds);
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  const int falls = argc > 3 ? std::atoi(argv[3]) : 16;
  if (argc < 3 || falls < 1) {
    std::fprintf(stderr, "usage: get_up BUNDLE LIBRARY [FALLS]\n");
    return 2;
  }
  const absl::Status status = Run(argv[1], argv[2], falls);
  if (!status.ok()) {
    std::fprintf(stderr, "get_up: %s\n", status.ToString().c_str());
  }
  return status.ok() ? 0 : 1;
}
