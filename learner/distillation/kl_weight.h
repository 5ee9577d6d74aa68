#ifndef SINEW_LEARNER_DISTILLATION_KL_WEIGHT_H_
#define SINEW_LEARNER_DISTILLATION_KL_WEIGHT_H_

#include <cstdint>

#include "proto/sinew/v1/distillation.pb.h"

namespace sinew::learner {

// Weight of the KL after so many rows were inserted into the memory: kl_weight
// up to kl_anneal_begin, kl_weight_final from kl_anneal_end on, linear between.
// Pure.
double KlWeight(const v1::Distillation& recipe, int64_t inserted_rows);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_KL_WEIGHT_H_
