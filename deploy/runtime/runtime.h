#ifndef SINEW_DEPLOY_RUNTIME_RUNTIME_H_
#define SINEW_DEPLOY_RUNTIME_RUNTIME_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "deploy/bundle/bundle.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/reference_feed.h"
#include "sim/character/model_ptr.h"
#include "sim/world/action.h"
#include "sim/world/body_state.h"
#include "sim/world/observation.h"
#include "sim/world/recovery.h"

namespace sinew::runtime {

// Runs a bundle: from the state of a body and a reference to joint targets, as
// an actor does in training, with its code, bit for bit. What plain numbers
// mean is said in sinew_runtime.h, the same thing for C.
//
//   SINEW_ASSIGN_OR_RETURN(auto policy, Runtime::Open("bundle"));
//   policy->LoadLibrary("library");  policy->Play("walk", 0, Align::kToBody);
//   policy->Reset(state, /*reference=*/nullptr);
//   each control step:  policy->Step(state, target);
//
// Thread-safety: one caller; any number of objects. Ownership: owns bundle,
// library and buffers; poses are borrowed for the call. Blocking: Open and
// LoadLibrary read files; Reset and Step neither allocate (unless they fail)
// nor lock. Errors: INVALID_ARGUMENT names the number that is wrong,
// FAILED_PRECONDITION the call that is missing, INTERNAL a policy that gave
// numbers that are not finite; the object is then as before the call.
class Runtime {
 public:
  using Align = ReferenceFeed::Align;

  static absl::StatusOr<std::unique_ptr<Runtime>> Open(
      const std::string& bundle_directory);

  const bundle::Bundle& bundle() const { return bundle_; }
  const character::Character& character() const { return *bundle_.character; }
  int num_joints() const;
  double control_hz() const { return bundle_.manifest.control_hz(); }
  // What a reference must have beside root and joints.
  const PoseNeeds& reference_needs() const { return reference_needs_; }

  // A motion library as reference: see ReferenceFeed.
  absl::Status LoadLibrary(const std::string& directory);
  const motion::Library* library() const { return feed_->library(); }
  absl::Status Play(absl::string_view clip, double seconds, Align align);
  absl::Status Seek(double seconds) { return feed_->Seek(seconds); }
  bool is_over() const { return feed_->is_over(); }
  // The clip's frame `ahead` >= 0 control steps from now.
  absl::Status ReadReference(int ahead, PoseBuffer* out);

  // Control steps ahead of now of the frames that StepTo takes.
  absl::Span<const int> frames() const { return feed_->offsets(); }

  // Begins an episode at `state`: aligns the clip, sets the previous target.
  // `reference`: the frame of now; null where a clip plays.
  absl::Status Reset(const Pose& state, const Pose* reference);

  // One control step: targets [J] rad. Step follows the clip and moves it on;
  // StepTo takes the caller's frames.
  absl::Status Step(const Pose& state, absl::Span<double> target);
  absl::Status StepTo(const Pose& state, absl::Span<const Pose> frames,
                      absl::Span<double> target);

  // Of the last step: observation [O], action [J]; and the target that the next
  // step will take for the previous one.
  absl::Span<const float> observation() const { return observation_; }
  absl::Span<const float> action() const;
  absl::Span<const double> previous_target() const { return previous_target_; }

 private:
  Runtime(bundle::Bundle bundle, world::ObservationBuilder observation);
  absl::Status Bind();
  absl::Status CheckStep(const Pose& state, absl::Span<double> target) const;
  void PlaceBody(const Pose& state);
  void Observe(const Pose& state);
  absl::Status Act(const Pose& state, absl::Span<double> target);

  const bundle::Bundle bundle_;
  const world::ObservationBuilder builder_;
  const world::BodyReader reader_;
  const world::ActionLaw law_;
  world::RecoveryLaw recovery_;
  bool is_out_of_sight_ = false;  // the next frame, of the last Observe
  PoseNeeds state_needs_, reference_needs_;
  std::unique_ptr<ReferenceFeed> feed_;
  std::unique_ptr<policy::Executor> executor_;
  absl::Span<float> observation_;  // the executor's input
  int action_tap_ = -1;

  bool is_reset_ = false;
  const character::DataPtr data_;
  world::BodyState body_;
  std::vector<float> self_contact_;
  std::vector<double> previous_target_, shown_target_, new_target_;
};

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_RUNTIME_H_
