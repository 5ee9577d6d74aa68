#include "common/config/recipe.h"

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/config/text_proto.h"
#include "common/status_macros.h"
#include "google/protobuf/text_format.h"

namespace sinew {

absl::StatusOr<v1::Recipe> ParseRecipe(absl::string_view text,
                                       absl::string_view source) {
  v1::Recipe recipe;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, source, recipe));
  return recipe;
}

double RecoveryShare(const v1::Recovery& recovery) {
  return FallenShare(recovery) + recovery.far_share();
}

double FallenShare(const v1::Recovery& recovery) {
  return recovery.fallen_share() + recovery.get_up_share();
}

bool IsSelfBlock(int block) {
  return block == v1::Observation::BLOCK_SELF_JOINT_SPACE ||
         block == v1::Observation::BLOCK_PREVIOUS_TARGET ||
         block == v1::Observation::BLOCK_SELF_CONTACT ||
         block == v1::Observation::BLOCK_SELF_BODIES;
}

int LeadingSelfBlocks(const v1::Observation& observation) {
  int count = 0;
  while (count < observation.blocks_size() &&
         IsSelfBlock(observation.blocks(count))) {
    ++count;
  }
  return count;
}

int RecordedLatentWidth(const v1::Recipe& recipe) {
  return recipe.has_distillation() ? 0 : recipe.network().latent().width();
}

bool IsBlindPlacement(v1::Action::Placement placement) {
  return placement == v1::Action::PLACEMENT_ABSOLUTE ||
         placement == v1::Action::PLACEMENT_AROUND_CURRENT;
}

std::string PrintRecipe(const v1::Recipe& recipe) {
  std::string text;
  SINEW_CHECK(google::protobuf::TextFormat::PrintToString(recipe, &text));
  return text;
}

}  // namespace sinew
