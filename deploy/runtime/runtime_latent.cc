// What a bundle with a latent adds to the runtime.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "deploy/runtime/runtime.h"

namespace sinew::runtime {

int Runtime::latent_width() const {
  return latent_ == nullptr ? 0 : latent_->width();
}

int Runtime::self_observation_width() const {
  return static_cast<int>(self_observation_.size());
}

absl::Status Runtime::CheckLatent(absl::string_view what, size_t size) const {
  if (latent_ == nullptr) {
    return absl::FailedPreconditionError("this bundle has no latent");
  }
  if (size == latent_input_.size()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(what, ": expected ", latent_input_.size(),
                   " numbers, as wide as the latent, found ", size));
}

absl::Status Runtime::CheckGaussian(absl::Span<double> mean,
                                    absl::Span<double> std) const {
  SINEW_RETURN_IF_ERROR(CheckLatent("mean", mean.size()));
  return CheckLatent("std", std.size());
}

absl::Status Runtime::ReadLatent(absl::string_view what,
                                 absl::Span<const double> values) {
  SINEW_RETURN_IF_ERROR(CheckLatent(what, values.size()));
  for (size_t i = 0; i < values.size(); ++i) {
    latent_input_[i] = static_cast<float>(values[i]);
    if (std::isfinite(latent_input_[i])) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        what, "[", i, "]: expected a finite float32, found ", values[i]));
  }
  return absl::OkStatus();
}

absl::Status Runtime::CheckSelf(const Pose& state) const {
  if (self_builder_.Has(v1::Observation::BLOCK_PREVIOUS_TARGET) &&
      state.previous_target == nullptr && !is_reset_) {
    return absl::FailedPreconditionError(
        "state.previous_target: expected numbers or a reset first, found "
        "neither");
  }
  return CheckPose(state, state_needs_, "state");
}

absl::Status Runtime::ObserveSelf(const Pose& state) {
  ReadBody(state, self_builder_);
  self_builder_.Build({.body = &body_,
                       .reference = {},
                       .reference_contact = {},
                       .previous_target = shown_target_,
                       .self_contact = self_contact_},
                      absl::MakeSpan(self_observation_));
  return CheckObserved(self_observation_);
}

absl::Status Runtime::SelfObservation(const Pose& state,
                                      absl::Span<float> out) {
  SINEW_RETURN_IF_ERROR(CheckLatent("latent", latent_input_.size()));
  if (out.size() != self_observation_.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("self_observation: expected room for ",
                     self_observation_.size(), " numbers, found ", out.size()));
  }
  SINEW_RETURN_IF_ERROR(CheckSelf(state));
  SINEW_RETURN_IF_ERROR(ObserveSelf(state));
  std::copy(self_observation_.begin(), self_observation_.end(), out.begin());
  return absl::OkStatus();
}

absl::Status Runtime::GiveGaussian(const LatentNetworks::Gaussian& latent,
                                   absl::Span<double> mean,
                                   absl::Span<double> std) {
  SINEW_RETURN_IF_ERROR(CheckFinite("mean of the latent", latent.mean));
  SINEW_RETURN_IF_ERROR(CheckFinite("std of the latent", latent.std));
  std::copy(latent.mean.begin(), latent.mean.end(), mean.begin());
  std::copy(latent.std.begin(), latent.std.end(), std.begin());
  return absl::OkStatus();
}

absl::Status Runtime::EncodeObserved(const Pose& state, absl::Span<double> mean,
                                     absl::Span<double> std) {
  SINEW_RETURN_IF_ERROR(Observe(state));
  return GiveGaussian(latent_->Encode(observation_), mean, std);
}

absl::Status Runtime::Encode(const Pose& state, absl::Span<double> mean,
                             absl::Span<double> std) {
  SINEW_RETURN_IF_ERROR(CheckGaussian(mean, std));
  SINEW_RETURN_IF_ERROR(CheckReset("encode", state));
  if (!feed_->playing()) {
    return absl::FailedPreconditionError("encode: expected a clip to play");
  }
  feed_->LoadPlayed();
  SINEW_RETURN_IF_ERROR(EncodeObserved(state, mean, std));
  feed_->Advance();
  return absl::OkStatus();
}

absl::Status Runtime::EncodeTo(const Pose& state, absl::Span<const Pose> frames,
                               absl::Span<double> mean,
                               absl::Span<double> std) {
  SINEW_RETURN_IF_ERROR(CheckGaussian(mean, std));
  SINEW_RETURN_IF_ERROR(CheckReset("encode", state));
  SINEW_RETURN_IF_ERROR(CheckFrames(frames));
  feed_->LoadGiven(frames);
  return EncodeObserved(state, mean, std);
}

absl::Status Runtime::Prior(const Pose& state, absl::Span<double> mean,
                            absl::Span<double> std) {
  SINEW_RETURN_IF_ERROR(CheckGaussian(mean, std));
  SINEW_RETURN_IF_ERROR(CheckSelf(state));
  SINEW_RETURN_IF_ERROR(ObserveSelf(state));
  return GiveGaussian(latent_->Prior(self_observation_), mean, std);
}

// What a step without a reference begins with.
absl::Status Runtime::ObserveBlindly(absl::string_view what,
                                     absl::Span<const double> values,
                                     const Pose& state,
                                     absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(ReadLatent(what, values));
  SINEW_RETURN_IF_ERROR(CheckTarget(target));
  SINEW_RETURN_IF_ERROR(CheckSelf(state));
  return ObserveSelf(state);
}

absl::Status Runtime::Decode(const Pose& state, absl::Span<const double> latent,
                             absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(ObserveBlindly("latent", latent, state, target));
  return ActBlindly(latent_->Decode(self_observation_, latent_input_), target);
}

absl::Status Runtime::Sample(const Pose& state, absl::Span<const double> noise,
                             absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(ObserveBlindly("noise", noise, state, target));
  return ActBlindly(latent_->Sample(self_observation_, latent_input_), target);
}

// An action's target without a reference: what the law of a bundle with a
// latent does with one, too.
absl::Status Runtime::ActBlindly(absl::Span<const float> action,
                                 absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(CheckFinite("action", action));
  law_.Target(body_.joint_position, /*next=*/nullptr, action,
              absl::MakeSpan(new_target_));
  TakeTarget(target);
  return absl::OkStatus();
}

}  // namespace sinew::runtime
