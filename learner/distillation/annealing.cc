#include "learner/distillation/annealing.h"

#include <cmath>

namespace sinew::learner {
namespace {

// Share of the way from `begin` to `end`, [0, 1]; 1 where they are one.
double ShareOf(int64_t begin, int64_t end, int64_t rows) {
  if (rows >= end) return 1;
  if (rows <= begin) return 0;
  return static_cast<double>(rows - begin) / static_cast<double>(end - begin);
}

}  // namespace

double KlWeight(const v1::Distillation& recipe, int64_t inserted_rows) {
  const double share =
      ShareOf(recipe.kl_anneal_begin(), recipe.kl_anneal_end(), inserted_rows);
  return std::lerp(recipe.kl_weight(), recipe.kl_weight_final(), share);
}

double LearningRate(const v1::Distillation& recipe, int64_t inserted_rows) {
  const double first = recipe.learning_rate();
  if (recipe.rate_anneal_end() == 0) return first;
  const double share = ShareOf(recipe.rate_anneal_begin(),
                               recipe.rate_anneal_end(), inserted_rows);
  if (share == 1) return recipe.learning_rate_final();
  return first * std::pow(recipe.learning_rate_final() / first, share);
}

}  // namespace sinew::learner
