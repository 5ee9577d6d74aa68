#ifndef SINEW_COMMON_CONFIG_PROCEDURE_VALIDATE_H_
#define SINEW_COMMON_CONFIG_PROCEDURE_VALIDATE_H_

#include "common/config/field_checker.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {

// The part of ValidateRecipe (recipe.h) that looks at trainings in stages: when
// one has stopped improving, PHC+, the composer. Thread-safety: pure. Blocking:
// never. Errors: in `check`.
void CheckStages(const v1::Recipe& recipe, FieldChecker& check);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_PROCEDURE_VALIDATE_H_
