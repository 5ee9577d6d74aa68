#include "sim/world/randomisation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/character/end_effectors.h"

namespace sinew::world {
namespace {

// Indices of the draws for a push.
enum PushIndex : uint64_t {
  kBegin = 0,
  kBody = 1,
  kImpulse = 2,
  kHeight = 3,
  kAzimuth = 4,
};

// Uniform within +-1.
double Signed(const RandomKey& key, uint64_t index) {
  return 2 * Uniform(key, index) - 1;
}

uint64_t Steps(double seconds, double control_hz) {
  return static_cast<uint64_t>(std::max(1.0, std::round(seconds * control_hz)));
}

}  // namespace

absl::StatusOr<Randomisation> Randomisation::Create(
    const v1::Recipe& recipe, const character::Character& character) {
  Randomisation random;
  random.recipe_ = recipe.task().randomisation();
  const v1::Randomisation& options = random.recipe_;
  random.on_ = options.mass() > 0 || options.friction() > 0 ||
               options.joint_offset() > 0 || options.gain() > 0 ||
               options.push_impulse() > 0;
  random.num_bodies_ = static_cast<int>(character.model()->nbody);
  random.num_joints_ = static_cast<int>(character.joints().size());
  if (options.push_impulse() > 0) {
    const double hz = recipe.physics().control_hz();
    random.interval_steps_ = Steps(options.push_interval(), hz);
    random.push_steps_ =
        std::min(Steps(options.push_seconds(), hz), random.interval_steps_);
    random.push_seconds_ = static_cast<double>(random.push_steps_) / hz;
    SINEW_RETURN_IF_ERROR(random.FindPushBodies(character));
  }
  return random;
}

absl::Status Randomisation::FindPushBodies(
    const character::Character& character) {
  std::vector<std::string> names(recipe_.push_bodies().begin(),
                                 recipe_.push_bodies().end());
  if (names.empty()) {
    push_bodies_ = {1};  // the root
    if (character.head_body() > 0) {
      push_bodies_.push_back(character.head_body());
    }
    SINEW_ASSIGN_OR_RETURN(names, character::EndEffectors(character));
  }
  for (const std::string& name : names) {
    const int body = mj_name2id(character.model(), mjOBJ_BODY, name.c_str());
    if (body < 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "recipe field task.randomisation.push_bodies: expected bodies of "
          "character ",
          character.name(), ", found \"", name, "\""));
    }
    push_bodies_.push_back(body);
  }
  return absl::OkStatus();
}

Conditions Randomisation::MakeConditions() const {
  Conditions conditions;
  if (!on_) return conditions;
  conditions.mass_scale.assign(num_bodies_, 1);
  conditions.joint_offset.assign(num_joints_, 0);
  conditions.gain_scale.assign(num_joints_, 1);
  return conditions;
}

void Randomisation::Draw(RandomKey key, Conditions* conditions) const {
  key.step = 0;
  key.purpose = RandomPurpose::kModelField;
  uint64_t index = 0;
  for (double& scale : conditions->mass_scale) {
    scale = 1 + recipe_.mass() * Signed(key, index++);
  }
  conditions->friction_scale = 1 + recipe_.friction() * Signed(key, index++);
  for (double& offset : conditions->joint_offset) {
    offset = recipe_.joint_offset() * Signed(key, index++);
  }
  for (double& scale : conditions->gain_scale) {
    scale = 1 + recipe_.gain() * Signed(key, index++);
  }
  conditions->key = key;
  conditions->key.purpose = RandomPurpose::kPush;
}

Push Randomisation::PushAt(const Conditions& conditions, int32_t step) const {
  Push push;
  if (!(recipe_.push_impulse() > 0)) return push;
  RandomKey key = conditions.key;
  key.step = static_cast<uint64_t>(step) / interval_steps_;
  const uint64_t within = static_cast<uint64_t>(step) % interval_steps_;
  const uint64_t begin =
      UniformInt(key, interval_steps_ - push_steps_ + 1, kBegin);
  if (within < begin || within >= begin + push_steps_) return push;
  push.body = push_bodies_[UniformInt(key, push_bodies_.size(), kBody)];
  const double force =
      Uniform(key, kImpulse) * recipe_.push_impulse() / push_seconds_;
  // Uniform on the sphere: height and azimuth are.
  const double height = Signed(key, kHeight);
  const double azimuth = 2 * std::numbers::pi * Uniform(key, kAzimuth);
  const double across = std::sqrt(1 - height * height);
  push.force[0] = force * across * std::cos(azimuth);
  push.force[1] = force * across * std::sin(azimuth);
  push.force[2] = force * height;
  return push;
}

}  // namespace sinew::world
