#include "sim/character/end_effectors.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace sinew::character {
namespace {

// The last body that a hinge of this meaning moves; 0: none.
int LastBody(const Character& character, const std::string& meaning) {
  const mjModel& model = *character.model();
  int body = 0;
  for (const v1::Joint& joint : character.proto().joints()) {
    const std::string& semantic =
        joint.semantic().empty() ? joint.name() : joint.semantic();
    if (semantic != meaning && !absl::StartsWith(semantic, meaning + "_")) {
      continue;
    }
    const int id = mj_name2id(&model, mjOBJ_JOINT, joint.name().c_str());
    body = std::max(body, model.jnt_bodyid[id]);
  }
  return body;
}

// The only child of a body if it is welded to it, else the body.
int Welded(const mjModel& model, int body) {
  int child = body;
  for (int b = body + 1; b < model.nbody; ++b) {
    if (model.body_parentid[b] != body) continue;
    if (child != body || model.body_jntnum[b] > 0) return body;
    child = b;
  }
  return mj_id2name(&model, mjOBJ_BODY, child) == nullptr ? body : child;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> EndEffectors(
    const Character& character) {
  const mjModel& model = *character.model();
  std::vector<std::string> names;
  for (const char* side : {"left", "right"}) {
    int hand = LastBody(character, absl::StrCat(side, "_wrist"));
    if (hand == 0) hand = LastBody(character, absl::StrCat(side, "_elbow"));
    if (hand == 0) {
      return absl::FailedPreconditionError(absl::StrCat(
          "character ", character.name(), ": expected a joint with semantic ",
          side, "_wrist or ", side, "_elbow, found none"));
    }
    names.push_back(mj_id2name(&model, mjOBJ_BODY, Welded(model, hand)));
  }
  for (const int foot : character.foot_bodies()) {
    names.push_back(mj_id2name(&model, mjOBJ_BODY, foot));
  }
  return names;
}

}  // namespace sinew::character
