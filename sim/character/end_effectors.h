#ifndef SINEW_SIM_CHARACTER_END_EFFECTORS_H_
#define SINEW_SIM_CHARACTER_END_EFFECTORS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "sim/character/character.h"

namespace sinew::character {

// The bodies whose places say most of a pose: left hand, right hand, then the
// feet as the character names them. A hand is the body that the last hinge with
// semantic left_wrist or left_wrist_* moves, without one left_elbow's, or what
// is welded to that alone; so likewise on the right.
//
// Pure. FAILED_PRECONDITION naming the side that has neither wrist nor elbow.
absl::StatusOr<std::vector<std::string>> EndEffectors(
    const Character& character);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_END_EFFECTORS_H_
