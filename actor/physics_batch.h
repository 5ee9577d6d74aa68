#ifndef SINEW_ACTOR_PHYSICS_BATCH_H_
#define SINEW_ACTOR_PHYSICS_BATCH_H_

#include <mujoco/mjbatch.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace sinew::actor {

// The physics rows of several environments of one model, and one mjData that
// serves them in turn: MuJoCo's mjBatch with the caller as its only thread. An
// engine error (mju_error) ends the call at hand instead of the process.
//
// Thread-safety: one caller. Ownership: owns rows, data and a copy of the
// model. Blocking: Apply runs its function; nothing allocates after Create.
// Errors: Create says why MuJoCo could not make the batch.
class PhysicsBatch {
 public:
  static absl::StatusOr<PhysicsBatch> Create(const mjModel* model, int size);

  int size() const { return mjb_nsim(batch_.get()); }

  // Physics row (mjSTATE_INTEGRATION) of an environment.
  absl::Span<double> row(int index) {
    const int width = mjb_nstate(batch_.get());
    return absl::MakeSpan(mjb_state(batch_.get()) + index * width, width);
  }

  // Puts the row into the data, calls function(mjData*), and takes the row out
  // again if `save`. What else the data holds is left from earlier calls. False
  // if the engine raised an error: the function was left at some point (no
  // destructors run, so it must not own anything), the row is unusable.
  template <typename Function>
  [[nodiscard]] bool Apply(int index, bool save, Function&& function) {
    using Callable = std::remove_reference_t<Function>;
    const mjfBatchFunc call = [](const mjModel*, mjData* data, int,
                                 void* callable) {
      (*static_cast<Callable*>(callable))(data);
    };
    mjb_apply(batch_.get(), &index, 1, call, &function, save ? 1 : 0);
    return mjb_status(batch_.get())[index] == 0;
  }

  // FAILED_PRECONDITION, since every actor of this build would fare alike: what
  // the engine said where the environment's last call ended so; `doing` says
  // what the call was for.
  absl::Status EngineError(int index, absl::string_view doing) const;

 private:
  struct Deleter {
    void operator()(mjBatch* batch) const { mjb_deleteBatch(batch); }
  };
  explicit PhysicsBatch(mjBatch* batch) : batch_(batch) {}

  std::unique_ptr<mjBatch, Deleter> batch_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_PHYSICS_BATCH_H_
