#include "actor/physics_batch.h"

#include "absl/strings/str_cat.h"

namespace sinew::actor {

absl::StatusOr<PhysicsBatch> PhysicsBatch::Create(const mjModel* model,
                                                  int size) {
  mjBatchConfig config;
  mjb_defaultConfig(&config);
  config.nthread = 1;
  config.persistent = 0;
  char error[256] = "";
  mjBatch* batch = mjb_makeBatch(model, size, &config, error,
                                 static_cast<int>(sizeof error));
  if (batch == nullptr) {
    return absl::InternalError(absl::StrCat("MuJoCo could not make a batch of ",
                                            size, " simulations: ", error));
  }
  return PhysicsBatch(batch);
}

absl::Status PhysicsBatch::EngineError(int index,
                                       absl::string_view doing) const {
  return absl::FailedPreconditionError(
      absl::StrCat("MuJoCo stopped while ", doing, " (environment ", index,
                   " of the batch): ", mjb_error(batch_.get(), index)));
}

}  // namespace sinew::actor
