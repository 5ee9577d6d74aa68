#include "sim/character/mirror_joints.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::character {

MirrorPartners MakePartners(
    const google::protobuf::RepeatedPtrField<v1::MirrorPair>& pairs) {
  MirrorPartners partners;
  for (const v1::MirrorPair& pair : pairs) {
    const float sign = pair.sign() < 0 ? -1 : 1;
    partners[pair.left()] = {pair.right(), sign};
    partners[pair.right()] = {pair.left(), sign};
  }
  return partners;
}

absl::StatusOr<RowMirror> MirrorJoints(const Character& character) {
  const MirrorPartners partners =
      MakePartners(character.proto().mirror_joints());
  std::map<std::string, int> index;
  for (const JointInfo& joint : character.joints()) {
    index.emplace(joint.name, static_cast<int>(index.size()));
  }
  RowMirror mirror;
  for (const JointInfo& joint : character.joints()) {
    const auto partner = partners.find(joint.name);
    if (partner == partners.end()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "character ", character.name(), ": mirror_joints: expected a pair ",
          "with joint ", joint.name, ", found none"));
    }
    mirror.source.push_back(index.at(partner->second.name));
    mirror.sign.push_back(partner->second.sign);
  }
  SINEW_RETURN_IF_ERROR(CheckRowMirror(mirror));
  return mirror;
}

}  // namespace sinew::character
