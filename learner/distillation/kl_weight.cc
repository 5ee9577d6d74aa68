#include "learner/distillation/kl_weight.h"

namespace sinew::learner {

double KlWeight(const v1::Distillation& recipe, int64_t samples) {
  const int64_t begin = recipe.kl_anneal_begin();
  const int64_t end = recipe.kl_anneal_end();
  if (samples >= end) return recipe.kl_weight_final();
  if (samples <= begin) return recipe.kl_weight();
  const double share =
      static_cast<double>(samples - begin) / static_cast<double>(end - begin);
  return recipe.kl_weight() +
         share * (recipe.kl_weight_final() - recipe.kl_weight());
}

}  // namespace sinew::learner
