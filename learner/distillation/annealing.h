#ifndef SINEW_LEARNER_DISTILLATION_ANNEALING_H_
#define SINEW_LEARNER_DISTILLATION_ANNEALING_H_

#include <cstdint>

#include "proto/sinew/v1/distillation.pb.h"

namespace sinew::learner {

// What falls while a student learns, after so many rows were inserted into the
// memory. `recipe`: defaults filled, valid. Pure.

// Weight of the KL: kl_weight up to kl_anneal_begin, kl_weight_final from
// kl_anneal_end on, linear between.
double KlWeight(const v1::Distillation& recipe, int64_t inserted_rows);

// learning_rate up to rate_anneal_begin, learning_rate_final from
// rate_anneal_end on, geometric between; learning_rate where rate_anneal_end is
// unset.
double LearningRate(const v1::Distillation& recipe, int64_t inserted_rows);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_ANNEALING_H_
