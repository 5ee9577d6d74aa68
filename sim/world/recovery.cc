#include "sim/world/recovery.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/world/get_up_frames.h"

namespace sinew::world {
namespace {

// Indices of the draws under one key.
enum DrawIndex : uint64_t {
  kKind = 0,
  kFallenState = 1,
  kDistance = 2,
  kDirection = 3,
  kTurn = 4,
};

constexpr double kFullTurn = 2 * std::numbers::pi;

int DrawFallen(const RandomKey& key, int fallen_states) {
  return static_cast<int>(
      UniformInt(key, static_cast<uint64_t>(fallen_states), kFallenState));
}

}  // namespace

BodyStart RecoveryLaw::Draw(RandomKey key, int fallen_states) const {
  key.step = 0;
  key.purpose = RandomPurpose::kRecovery;
  BodyStart start;
  const double kind = Uniform(key, kKind);
  if (kind >= RecoveryShare(recipe_)) return start;
  start.recovery_steps = recipe_.steps();
  start.turn = kFullTurn * Uniform(key, kTurn);
  if (kind < recipe_.fallen_share()) {
    start.kind = v1::START_KIND_FALLEN;
    start.fallen_state = DrawFallen(key, fallen_states);
  } else if (kind < recipe_.fallen_share() + recipe_.far_share()) {
    start.kind = v1::START_KIND_FAR;
    const double distance =
        std::sqrt(Uniform(key, kDistance)) * recipe_.far_offset();
    const double direction = kFullTurn * Uniform(key, kDirection);
    start.offset_x = distance * std::cos(direction);
    start.offset_y = distance * std::sin(direction);
  } else {
    start = {.kind = v1::START_KIND_GET_UP,
             .fallen_state = DrawFallen(key, fallen_states),
             .recovery_steps = recipe_.get_up_steps()};
  }
  return start;
}

double RecoveryLaw::Reward(double tracking, double before, double after) const {
  const double goal =
      recipe_.goal_weight() * std::min(before - after, recipe_.max_gain());
  return after < recipe_.near_distance()
             ? goal + recipe_.near_factor() * tracking
             : goal;
}

bool RecoveryLaw::Hide(const BodyState& body, BodyState* reference) const {
  const Eigen::Vector3d between = reference->position[0] - body.position[0];
  const double distance = between.norm();
  if (!IsFar(distance)) return false;
  *reference = body;
  const Eigen::Vector3d shift = between * (recipe_.far_distance() / distance);
  for (Eigen::Vector3d& position : reference->position) position += shift;
  return true;
}

RecoveryWatch::RecoveryWatch(const character::Character& character,
                             double max_mean_distance)
    : max_mean_distance_(max_mean_distance),
      upright_height_(UprightRootHeight(character)) {
  const std::vector<int>& tracked = character.tracked();
  const auto head =
      std::find(tracked.begin(), tracked.end(), character.head_body() - 1);
  if (character.head_body() > 0 && head != tracked.end()) {
    head_ = static_cast<int>(head - tracked.begin());
  }
}

void RecoveryWatch::Add(double mean_distance, const BodyState& body,
                        const BodyState& reference) {
  ++frame_;
  const bool holds =
      mean_distance < max_mean_distance_ &&
      reference.position[0].z() >= upright_height_ &&
      body.position[head_].z() >= kHeadShare * reference.position[head_].z();
  if (!holds) {
    since_ = -1;
  } else if (since_ < 0) {
    since_ = frame_;
  }
}

}  // namespace sinew::world
