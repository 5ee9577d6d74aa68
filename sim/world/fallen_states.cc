#include "sim/world/fallen_states.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "sim/world/actuation.h"

namespace sinew::world {
namespace {

constexpr char kFormat[] = "sinew.fallen_states";
constexpr char kVersion[] = "1";
constexpr char kTensor[] = "qpos";
// Metres between the floor and what bounds the body's lowest geom.
constexpr double kClearance = 0.02;
constexpr double kLargestAction = 0.5;
// Range of a joint without limits, rad to each side.
constexpr double kFreeRange = 1.5;
// Simulations that diverge are begun anew, so often.
constexpr uint64_t kAttempts = 20;
// More than a recipe can have (fallen_states is an int32).
constexpr uint64_t kFirstOfEvaluation = uint64_t{1} << 32;

// Drops one body after the other.
class Dropper {
 public:
  Dropper(const character::Character& character, const v1::Physics& physics)
      : character_(character),
        model_(character.model()),
        data_(mj_makeData(model_)),
        actuation_(character, Substeps(physics), /*ramp=*/false),
        steps_(static_cast<int>(
            std::lround(FallenStates::kDropSeconds * physics.control_hz()))),
        noise_(character.joints().size()),
        target_(character.joints().size()) {}

  // False if the simulation diverged.
  bool Drop(RandomKey key) {
    mj_resetData(model_, data_.get());
    Place(key);
    for (int step = 0; step < steps_; ++step) {
      key.step = static_cast<uint64_t>(step) + 1;
      DrawTarget(key);
      if (actuation_.Run(target_, target_, data_.get()).diverged) return false;
    }
    return true;
  }

  // Of the last Drop; root moved to x = y = 0.
  void AppendPosition(std::vector<double>* out) const {
    const size_t begin = out->size();
    out->insert(out->end(), data_->qpos, data_->qpos + model_->nq);
    double* root = out->data() + begin + character_.root_qpos_address();
    root[0] = root[1] = 0;
    mju_normalize4(root + 3);
  }

 private:
  // The default pose in a rotation uniform over all, just above the floor.
  void Place(const RandomKey& key) {
    double* root = data_->qpos + character_.root_qpos_address();
    for (const character::JointInfo& joint : character_.joints()) {
      data_->qpos[joint.qpos_address] = joint.default_position;
    }
    float turn[4];
    FillNormal(key, absl::MakeSpan(turn));
    for (int i = 0; i < 4; ++i) root[3 + i] = turn[i];
    mju_normalize4(root + 3);
    root[0] = root[1] = root[2] = 0;
    mj_kinematics(model_, data_.get());
    double lowest = 0;
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      if (model_->geom_bodyid[geom] == 0) continue;
      lowest = std::min(
          lowest, data_->geom_xpos[3 * geom + 2] - model_->geom_rbound[geom]);
    }
    root[2] = kClearance - lowest;
  }

  void DrawTarget(const RandomKey& key) {
    FillUniform(key, absl::MakeSpan(noise_));
    for (size_t j = 0; j < target_.size(); ++j) {
      const character::JointInfo& joint = character_.joints()[j];
      const bool limited =
          std::isfinite(joint.lower) && std::isfinite(joint.upper);
      const double middle =
          limited ? (joint.lower + joint.upper) / 2 : joint.default_position;
      const double half =
          limited ? (joint.upper - joint.lower) / 2 : kFreeRange;
      target_[j] = middle + kLargestAction * (2.0 * noise_[j] - 1) * half;
    }
  }

  const character::Character& character_;
  const mjModel* model_;
  const character::DataPtr data_;
  const Actuation actuation_;
  const int steps_;
  std::vector<float> noise_;
  std::vector<double> target_;
};

absl::Status Error(absl::string_view source, absl::string_view field,
                   absl::string_view expected, absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": fallen states: ", field, ": expected ", expected,
                   ", found ", found));
}

absl::Status CheckMetadata(const std::map<std::string, std::string>& metadata,
                           const character::Character& character,
                           absl::string_view source) {
  const std::pair<const char*, std::string> kExpected[] = {
      {"format", kFormat},
      {"format_version", kVersion},
      {"character_sha256", character.digest()}};
  for (const auto& [name, expected] : kExpected) {
    const auto found = metadata.find(name);
    const std::string value = found == metadata.end() ? "none" : found->second;
    if (value != expected) return Error(source, name, expected, value);
  }
  return absl::OkStatus();
}

absl::Status CheckPositions(absl::Span<const double> qpos, int width,
                            int root_address, absl::string_view source) {
  for (size_t i = 0; i < qpos.size(); ++i) {
    if (!std::isfinite(qpos[i])) {
      return Error(source,
                   absl::StrCat("qpos[", i / width, ", ", i % width, "]"),
                   "a finite number", absl::StrCat(qpos[i]));
    }
  }
  for (size_t i = 0; i < qpos.size(); i += width) {
    const double norm = mju_norm(qpos.data() + i + root_address + 3, 4);
    if (std::abs(norm - 1) > 1e-6) {
      return Error(source, absl::StrCat("qpos[", i / width, "]"),
                   "a unit quaternion", absl::StrCat("one of norm ", norm));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<FallenStates> FallenStates::Make(
    const character::Character& character, const v1::Recipe& recipe, int count,
    uint64_t seed) {
  return MakeFrom(character, recipe, count, seed, /*first_environment=*/0,
                  StopToken());
}

absl::StatusOr<FallenStates> FallenStates::MakeForEvaluation(
    const character::Character& character, const v1::Recipe& recipe, int count,
    const StopToken& stop) {
  return MakeFrom(character, recipe, count, kEvaluationSeed, kFirstOfEvaluation,
                  stop);
}

absl::StatusOr<FallenStates> FallenStates::MakeFrom(
    const character::Character& character, const v1::Recipe& recipe, int count,
    uint64_t seed, uint64_t first_environment, const StopToken& stop) {
  if (count < 1) {
    return Error("character " + character.name(), "count", ">= 1",
                 absl::StrCat(count));
  }
  FallenStates states(static_cast<int>(character.model()->nq),
                      character.digest());
  states.made_from_ =
      absl::StrCat("seed ", seed, ", ", recipe.physics().physics_hz(), " Hz");
  Dropper dropper(character, recipe.physics());
  for (int i = 0; i < count; ++i) {
    if (stop.stop_requested()) {
      return absl::CancelledError("fallen states: stopped before their end");
    }
    RandomKey key{.seed = seed,
                  .environment = first_environment + static_cast<uint64_t>(i),
                  .purpose = RandomPurpose::kFallenState};
    while (!dropper.Drop(key)) {
      if (++key.episode < kAttempts) continue;
      return absl::FailedPreconditionError(
          absl::StrCat("character ", character.name(), ": fallen state ", i,
                       ": expected a simulation that stays finite, found ",
                       kAttempts, " that diverged"));
    }
    dropper.AppendPosition(&states.qpos_);
  }
  return states;
}

absl::StatusOr<std::unique_ptr<const FallenStates>> FallenStates::MakeFor(
    const character::Character& character, const v1::Recipe& recipe) {
  const v1::Recovery& recovery = recipe.task().recovery();
  if (!(FallenShare(recovery) > 0)) return nullptr;
  SINEW_ASSIGN_OR_RETURN(FallenStates states,
                         Make(character, recipe, recovery.fallen_states(),
                              recovery.fallen_seed()));
  return std::make_unique<const FallenStates>(std::move(states));
}

absl::StatusOr<FallenStates> FallenStates::Parse(
    absl::string_view bytes, const character::Character& character,
    absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(const SafetensorsView view,
                         ViewSafetensors(bytes, source));
  SINEW_RETURN_IF_ERROR(CheckMetadata(view.metadata, character, source));
  SINEW_ASSIGN_OR_RETURN(const TensorMap tensors,
                         ParseSafetensors(bytes, source));
  const int width = static_cast<int>(character.model()->nq);
  const auto found = tensors.find(kTensor);
  if (found == tensors.end() || found->second.dtype != v1::DATA_TYPE_FLOAT64 ||
      found->second.shape.size() != 2 || found->second.shape[0] < 1 ||
      found->second.shape[1] != width) {
    return Error(source, kTensor, absl::StrCat("float64 [N >= 1, ", width, "]"),
                 "something else or none");
  }
  const absl::Span<const double> qpos = found->second.float64();
  SINEW_RETURN_IF_ERROR(
      CheckPositions(qpos, width, character.root_qpos_address(), source));
  FallenStates states(width, character.digest());
  const auto made_from = view.metadata.find("made_from");
  if (made_from != view.metadata.end()) states.made_from_ = made_from->second;
  states.qpos_.assign(qpos.begin(), qpos.end());
  return states;
}

std::string FallenStates::Serialize() const {
  return SerializeSafetensors(
      {{kTensor, HostTensor::Float64({size(), width_}, qpos_)}},
      {{"format", kFormat},
       {"format_version", kVersion},
       {"character_sha256", character_sha256_},
       {"made_from", made_from_}});
}

}  // namespace sinew::world
