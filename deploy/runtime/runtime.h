#ifndef SINEW_DEPLOY_RUNTIME_RUNTIME_H_
#define SINEW_DEPLOY_RUNTIME_RUNTIME_H_

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "deploy/bundle/bundle.h"
#include "deploy/runtime/latent_networks.h"
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
// A bundle with a latent can be steered instead of led, without any reference:
//
//   each control step:  policy->Sample(state, noise, target);
//   or:                 policy->Decode(state, latent, target);
//
// Thread-safety: one caller; any number of objects. Ownership: owns bundle,
// library and buffers; poses are borrowed for the call. Blocking: Open and
// LoadLibrary read files; PlayNearest takes milliseconds, and its first call
// for a kind of frames reads the library; all else that is done in a control
// step neither allocates (unless it fails) nor locks. Errors: INVALID_ARGUMENT
// names the number that is wrong, FAILED_PRECONDITION the call that is missing,
// INTERNAL a policy that gave numbers that are not finite; the object is then
// as before the call.
class Runtime {
 public:
  using Align = ReferenceFeed::Align;
  using Among = ReferenceFeed::Among;

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
  // Plays from the frame that is nearest to a body (ReferenceFeed); `stand`
  // steps at most kMostStand. An episode that has begun goes on: no Reset is
  // needed then. The mean distance of the body from that frame, m.
  static constexpr int kMostStand = 1 << 16;
  absl::StatusOr<double> PlayNearest(const Pose& state, Among among, int stand);
  // For how many steps a get-up's first frame stood in training; 0 where the
  // policy has not learnt from any.
  int get_up_steps() const;
  absl::Status Seek(double seconds) { return feed_->Seek(seconds); }
  // The name of the clip that plays, and the time in it of now, s; empty and 0
  // where none does.
  absl::string_view clip_name() const;
  double clip_seconds() const;
  bool is_over() const { return feed_->is_over(); }
  // The clip's frame `ahead` >= 0 control steps from now.
  absl::Status ReadReference(int ahead, PoseBuffer* out);

  // Control steps ahead of now of the frames that StepTo takes.
  absl::Span<const int> frames() const { return feed_->offsets(); }

  // Begins an episode at `state`: aligns the clip, sets the previous target (to
  // the joints' positions after PlayNearest, as where training begins on the
  // floor; else to what no action means there). `reference`: the frame of now;
  // null where a clip plays or the bundle has a latent.
  absl::Status Reset(const Pose& state, const Pose* reference);

  // One control step: targets [J] rad. Step follows the clip and moves it on;
  // StepTo takes the caller's frames.
  absl::Status Step(const Pose& state, absl::Span<double> target);
  absl::Status StepTo(const Pose& state, absl::Span<const Pose> frames,
                      absl::Span<double> target);

  // --- Bundles with a latent; others: FAILED_PRECONDITION, widths are 0 ------
  // Z and S: width of the latent, and of the body's own state.
  int latent_width() const;
  int self_observation_width() const;

  // What prior and decoder see of a state, [S]: the observation's first
  // columns.
  absl::Status SelfObservation(const Pose& state, absl::Span<float> out);

  // What the reference asks for: mean and standard deviation of the latent, [Z]
  // each. After a Reset. Encode follows the clip and moves it on, as Step does;
  // Decode of the mean then gives the target of Step, bit for bit.
  absl::Status Encode(const Pose& state, absl::Span<double> mean,
                      absl::Span<double> std);
  absl::Status EncodeTo(const Pose& state, absl::Span<const Pose> frames,
                        absl::Span<double> mean, absl::Span<double> std);
  // What this body would do next if nobody asked for anything.
  absl::Status Prior(const Pose& state, absl::Span<double> mean,
                     absl::Span<double> std);

  // Targets [J] rad of a latent [Z], and of N(0, 1) noise [Z] that becomes one
  // around the prior's mean. They need no reference, and a Reset only where the
  // body's own state has the previous target in it; the target is the previous
  // one of the next step. Numbers are rounded to float32.
  absl::Status Decode(const Pose& state, absl::Span<const double> latent,
                      absl::Span<double> target);
  absl::Status Sample(const Pose& state, absl::Span<const double> noise,
                      absl::Span<double> target);

  // Of the last Step or Encode: observation [O]; of the last Step:
  // action [J]; and the target that the next step will take for the previous
  // one.
  absl::Span<const float> observation() const { return observation_; }
  absl::Span<const float> action() const;
  absl::Span<const double> previous_target() const { return previous_target_; }

 private:
  Runtime(bundle::Bundle bundle, world::ObservationBuilder observation);
  absl::Status Bind();
  // `call`: "step", "encode".
  absl::Status CheckReset(absl::string_view call, const Pose& state) const;
  absl::Status CheckTarget(absl::Span<double> target) const;
  absl::Status CheckFrames(absl::Span<const Pose> frames) const;
  static absl::Status CheckFinite(absl::string_view what,
                                  absl::Span<const float> values);
  void PlaceBody(const Pose& state);
  // What `builder` sees of the body alone.
  void ReadBody(const Pose& state, const world::ObservationBuilder& builder);
  // Numbers that are finite each may be too large together.
  static absl::Status CheckObserved(absl::Span<const float> observation);
  absl::Status Observe(const Pose& state);
  absl::Status Act(const Pose& state, absl::Span<double> target);
  // new_target_ becomes the previous one, and the caller's.
  void TakeTarget(absl::Span<double> target);

  // runtime_latent.cc. `what` is a vector of the latent's width.
  absl::Status CheckLatent(absl::string_view what, size_t size) const;
  absl::Status CheckGaussian(absl::Span<double> mean,
                             absl::Span<double> std) const;
  absl::Status ReadLatent(absl::string_view what,
                          absl::Span<const double> values);
  static absl::Status GiveGaussian(const LatentNetworks::Gaussian& latent,
                                   absl::Span<double> mean,
                                   absl::Span<double> std);
  absl::Status CheckSelf(const Pose& state) const;
  absl::Status ObserveSelf(const Pose& state);
  absl::Status EncodeObserved(const Pose& state, absl::Span<double> mean,
                              absl::Span<double> std);
  absl::Status ObserveBlindly(absl::string_view what,
                              absl::Span<const double> values,
                              const Pose& state, absl::Span<double> target);
  absl::Status ActBlindly(absl::Span<const float> action,
                          absl::Span<double> target);

  const bundle::Bundle bundle_;
  const world::ObservationBuilder builder_;
  const world::ObservationBuilder self_builder_;
  const world::BodyReader reader_;
  const world::ActionLaw law_;
  world::RecoveryLaw recovery_;
  bool is_out_of_sight_ = false;  // the next frame, of the last Observe
  PoseNeeds state_needs_, reference_needs_;
  std::unique_ptr<ReferenceFeed> feed_;
  std::unique_ptr<policy::Executor> executor_;
  absl::Span<float> observation_;  // the executor's input
  int action_tap_ = -1;
  std::unique_ptr<LatentNetworks> latent_;  // null: the bundle has none
  std::vector<float> self_observation_;     // [S]
  std::vector<float> latent_input_;         // [Z]

  bool is_reset_ = false;
  const character::DataPtr data_;
  world::BodyState body_;
  // Where the reference's root was when it was looked at last.
  Eigen::Vector2d plane_ = Eigen::Vector2d::Zero();
  std::vector<float> self_contact_;
  std::vector<double> previous_target_, shown_target_, new_target_;
};

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_RUNTIME_H_
