#include "tools/evaluation/bundle_subject.h"

#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "tools/evaluation/fallen_figures.h"

namespace sinew::evaluation {

absl::StatusOr<BundleSubject> LoadBundleSubject(
    const std::string& bundle, const std::string& motions, int fallen_starts,
    std::optional<double> max_mean_body_distance) {
  SINEW_ASSIGN_OR_RETURN(bundle::Bundle read, bundle::ReadBundle(bundle));
  SINEW_ASSIGN_OR_RETURN(auto library, motion::Library::Load(motions));
  SINEW_RETURN_IF_ERROR(library->Verify());
  v1::Recipe recipe = bundle::TaskRecipe(read.manifest);
  if (max_mean_body_distance) {
    recipe.mutable_evaluation()->set_max_mean_body_distance(
        *max_mean_body_distance);
    SINEW_RETURN_IF_ERROR(ValidateRecipe(recipe));
  }
  SINEW_ASSIGN_OR_RETURN(
      auto character,
      character::Character::Load(read.character_file(), recipe.physics()));
  std::unique_ptr<const world::FallenStates> fallen;
  if (fallen_starts > 0) {
    SINEW_ASSIGN_OR_RETURN(
        fallen, MakeFallenStates(read.character_file(), fallen_starts));
  }
  auto subject = MakeSubject(recipe, std::move(character), std::move(library),
                             read.graph, read.weights, std::move(fallen));
  if (!subject.ok()) {
    return absl::Status(subject.status().code(),
                        absl::StrCat(motions, ": does not fit bundle ", bundle,
                                     ": ", subject.status().message()));
  }
  return BundleSubject{.subject = *std::move(subject),
                       .manifest = std::move(read.manifest)};
}

}  // namespace sinew::evaluation
