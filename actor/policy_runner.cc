#include "actor/policy_runner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/status_macros.h"

namespace sinew::actor {
namespace {

// Where policies that act through a latent show it.
constexpr char kLatentTap[] = "latent";

}  // namespace

absl::Status PolicyRunner::SetGraph(const ActingGraph& graph) {
  // The common case is new weights of the same graph.
  if (executor_ == nullptr || !executor_->SetWeights(graph.pack).ok()) {
    SINEW_ASSIGN_OR_RETURN(executor_,
                           policy::Executor::Create(graph.pack, max_batch_));
    SINEW_RETURN_IF_ERROR(Bind(graph.ports));
  }
  action_width_ = graph.action_width;
  latent_noise_width_ = graph.latent_noise_width;
  std_ = graph.std;
  log_normaliser_ = 0;
  for (double std : std_) {
    log_normaliser_ += std::log(std) + 0.5 * std::log(2 * std::numbers::pi);
  }
  return absl::OkStatus();
}

absl::Status PolicyRunner::Bind(const PolicyPorts& ports) {
  const auto rows = [this](const std::string& name) {
    const int index = executor_->input_index(name);
    return Rows{.values = executor_->input(index),
                .width = static_cast<size_t>(executor_->input_width(index))};
  };
  observation_ = rows(ports.observation);
  noise_.clear();
  size_t width = 0;
  for (const std::string& name : ports.noise) {
    noise_.push_back(rows(name));
    width += noise_.back().width;
  }
  draw_.resize(width);
  action_tap_ = executor_->tap_index(ports.action);
  mean_tap_ = executor_->tap_index(ports.mean);
  latent_tap_ = executor_->tap_index(kLatentTap);
  if (latent_tap_ >= 0) {
    latent_width_ = static_cast<size_t>(executor_->tap_width(latent_tap_));
  }
  latent_noise_tap_ = executor_->tap_index(ports.latent_noise);
  if (action_tap_ < 0 || mean_tap_ < 0) {
    return absl::InternalError("policy executor lacks a tap of its own graph");
  }
  return absl::OkStatus();
}

absl::Span<float> PolicyRunner::observation(int row) const {
  return observation_.values.subspan(row * observation_.width,
                                     observation_.width);
}

void PolicyRunner::DrawNoise(int row, const RandomKey& key, double scale) {
  FillNormal(key, absl::MakeSpan(draw_));
  for (float& number : draw_) number *= static_cast<float>(scale);
  const float* next = draw_.data();
  for (const Rows& noise : noise_) {
    std::copy_n(next, noise.width, noise.values.data() + row * noise.width);
    next += noise.width;
  }
}

void PolicyRunner::ClearNoise() {
  for (const Rows& noise : noise_) {
    std::fill(noise.values.begin(), noise.values.end(), 0.F);
  }
}

absl::Span<const float> PolicyRunner::Row(int tap, size_t width,
                                          int row) const {
  return executor_->tap(tap).subspan(row * width, width);
}

absl::Span<const float> PolicyRunner::action(int row) const {
  return Row(action_tap_, action_width_, row);
}

absl::Span<const float> PolicyRunner::mean(int row) const {
  return Row(mean_tap_, action_width_, row);
}

absl::Span<const float> PolicyRunner::latent(int row) const {
  if (latent_tap_ < 0) return {};
  return Row(latent_tap_, latent_width_, row);
}

absl::Span<const float> PolicyRunner::latent_noise(int row) const {
  if (latent_noise_tap_ < 0) return {};
  return Row(latent_noise_tap_, latent_noise_width_, row);
}

double PolicyRunner::LogProbability(int row) const {
  if (std_.empty()) return 0;
  const absl::Span<const float> a = action(row);
  const absl::Span<const float> m = mean(row);
  double squares = 0;
  for (size_t i = 0; i < std_.size(); ++i) {
    const double z =
        (static_cast<double>(a[i]) - static_cast<double>(m[i])) / std_[i];
    squares += z * z;
  }
  return -0.5 * squares - log_normaliser_;
}

}  // namespace sinew::actor
