#ifndef SINEW_SIM_CHARACTER_RESOLVE_H_
#define SINEW_SIM_CHARACTER_RESOLVE_H_

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/character.pb.h"
#include "sim/character/character.h"

namespace sinew::character {

// Finds what a character's text names in its compiled model.
//
// Thread-safety: immutable. Ownership: borrows its arguments. Blocking: never.
// Errors: INVALID_ARGUMENT naming `source`, the field, what was expected and
// what was found.
class Resolver {
 public:
  Resolver(const v1::Character& character, const mjModel& model,
           absl::string_view source)
      : character_(character), model_(model), source_(source) {}

  // One tree of bodies below the world with one free joint at its root, else
  // hinges; every hinge named by the character.
  absl::Status CheckTree() const;

  // The members of Character of the same names.
  absl::StatusOr<std::vector<JointInfo>> Joints() const;
  absl::StatusOr<std::vector<int>> Tracked() const;
  absl::Status Feet(std::vector<int>* bodies,
                    std::vector<std::vector<int>>* geoms) const;
  absl::StatusOr<std::vector<int>> Terminating(
      const std::vector<int>& tracked, const std::vector<int>& feet) const;
  absl::StatusOr<int> Head() const;
  absl::StatusOr<int> Floor() const;

  // Mirror pairs name joints of the character and bodies of the model, with
  // signs of +1 or -1.
  absl::Status CheckMirrors() const;

 private:
  absl::Status Bad(absl::string_view field, absl::string_view expected,
                   absl::string_view found) const;
  absl::StatusOr<int> Body(absl::string_view field,
                           const std::string& name) const;
  absl::StatusOr<std::vector<int>> Sole(const v1::Foot& foot, int body) const;

  const v1::Character& character_;
  const mjModel& model_;
  std::string source_;
};

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_RESOLVE_H_
