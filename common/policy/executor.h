#ifndef SINEW_COMMON_POLICY_EXECUTOR_H_
#define SINEW_COMMON_POLICY_EXECUTOR_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"   // IWYU pragma: export
#include "common/policy/validate.h"      // IWYU pragma: export
#include "common/policy/weights_pack.h"  // IWYU pragma: export

namespace sinew::policy {

// Runs one graph on the CPU in float32:
//
//   SINEW_ASSIGN_OR_RETURN(auto pack, PackWeights(graph, "policy", weights));
//   SINEW_ASSIGN_OR_RETURN(auto executor, Executor::Create(pack, 8));
//   const int observation = executor->input_index("observation");
//   const int mean = executor->tap_index("mean");
//   ... write executor->input(observation) ...
//   executor->Run(8);
//   ... read executor->tap(mean) ...
//
// Batch-invariant: a row's result depends on that row alone, bit for bit,
// whatever the batch size and the row's place in it. Results are equal on all
// machines of one build.
//
// Thread-safety: one executor per thread; the packed weights may be shared
//   (see WeightsPack). Ownership: keeps the pack alive. Blocking: never;
//   Run neither allocates nor locks. Errors: PackWeights validates everything,
//   so Run cannot fail (CHECKs on a batch out of range). NaN in gives NaN out.
class Executor {
 public:
  // `max_batch` rows at most per Run, >= 1; all workspace is allocated here.
  // INVALID_ARGUMENT: max_batch out of range.
  static absl::StatusOr<std::unique_ptr<Executor>> Create(
      std::shared_ptr<const WeightsPack> pack, int max_batch);
  virtual ~Executor() = default;

  // Index of an input or tap by name; -1 if absent. Resolve once, not per Run.
  virtual int input_index(absl::string_view name) const = 0;
  virtual int tap_index(absl::string_view name) const = 0;
  virtual int64_t input_width(int input) const = 0;
  virtual int64_t tap_width(int tap) const = 0;

  // Where the caller writes input rows: [max_batch, width] row-major. Inputs
  // that are never written are zero. Valid for the executor's life.
  virtual absl::Span<float> input(int input) = 0;

  // Evaluates the first `batch` rows, 0 <= batch <= max_batch.
  virtual void Run(int batch) = 0;

  // Result of the last Run: [max_batch, width] row-major, first `batch` rows
  // defined. Valid for the executor's life.
  virtual absl::Span<const float> tap(int tap) const = 0;

  // Takes another pack of the same graph (new weights), no allocation.
  // INVALID_ARGUMENT: the packs' graphs differ.
  virtual absl::Status SetWeights(std::shared_ptr<const WeightsPack> pack) = 0;
};

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_EXECUTOR_H_
