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

std::string PrintRecipe(const v1::Recipe& recipe) {
  std::string text;
  SINEW_CHECK(google::protobuf::TextFormat::PrintToString(recipe, &text));
  return text;
}

}  // namespace sinew
