#ifndef SINEW_COMMON_CONFIG_VARIANTS_VALIDATE_H_
#define SINEW_COMMON_CONFIG_VARIANTS_VALIDATE_H_

#include "common/config/field_checker.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {

// The part of ValidateRecipe (recipe.h) that looks at a task's variants:
// recovery, randomisation, actuator model. Thread-safety: pure. Blocking:
// never. Errors: in `check`.
void CheckVariants(const v1::Task& task, FieldChecker& check);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_VARIANTS_VALIDATE_H_
