#include "learner/distillation/kl_weight.h"

namespace sinew::learner {

double KlWeight(const v1::Distillation& recipe, int64_t inserted_rows) {
  const int64_t begin = recipe.kl_anneal_begin();
  const int64_t end = recipe.kl_anneal_end();
  if (inserted_rows >= end) return recipe.kl_weight_final();
  if (inserted_rows <= begin) return recipe.kl_weight();
  const double share = static_cast<double>(inserted_rows - begin) /
                       static_cast<double>(end - begin);
  return recipe.kl_weight() +
         share * (recipe.kl_weight_final() - recipe.kl_weight());
}

}  // namespace sinew::learner
