#ifndef SINEW_SIM_CHARACTER_MIRROR_JOINTS_H_
#define SINEW_SIM_CHARACTER_MIRROR_JOINTS_H_

#include <functional>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "common/segment/mirror.h"
#include "proto/sinew/v1/character.pb.h"
#include "sim/character/character.h"

namespace sinew::character {

// Left-right symmetry of a character, from the pairs that its text proto names.
// Thread-safety: pure functions. Errors: as stated.

// A name's mirror image and the sign of the mirrored coordinate.
struct MirrorPartner {
  std::string name;
  float sign = 1;
};
using MirrorPartners = std::map<std::string, MirrorPartner, std::less<>>;

// Both ways of every pair.
MirrorPartners MakePartners(
    const google::protobuf::RepeatedPtrField<v1::MirrorPair>& pairs);

// Joint coordinates of the mirrored body, in action order. FAILED_PRECONDITION
// naming the joint that has no partner (it may be its own).
absl::StatusOr<RowMirror> MirrorJoints(const Character& character);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MIRROR_JOINTS_H_
