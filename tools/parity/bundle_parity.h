#ifndef SINEW_TOOLS_PARITY_BUNDLE_PARITY_H_
#define SINEW_TOOLS_PARITY_BUNDLE_PARITY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "deploy/bundle/bundle.h"
#include "tools/parity/onnx_runtime.h"

namespace sinew::tools {

// How far two back ends may lie apart, relative to a tap's largest value.
inline constexpr double kParityTolerance = 1e-5;

struct ParityOptions {
  int rows = 64;      // random inputs, >= 1
  uint64_t seed = 1;  // of them
  // Unset: onnxruntime is left out.
  std::optional<OnnxRuntimeOptions> onnx = std::nullopt;
};

// One tap of a graph: largest difference of a back end from the executor, over
// the largest absolute value of the executor.
struct ParityRow {
  std::string graph;
  std::string tap;
  double torch = 0;
  std::optional<double> onnx = std::nullopt;
};

// Largest difference over the largest absolute value of `expected`, or by
// itself where that is 0. Infinite where the sizes differ, or any number is not
// finite. Pure.
double ParityDifference(absl::Span<const float> expected,
                        absl::Span<const float> found);

// Runs every graph of a bundle on the same random inputs by the executor, by
// libtorch and by onnxruntime (the graph's file NAME.onnx). Data (observations,
// latents) are normal with standard deviations of 0.1, 1 and 10 in turn, noise
// is N(0, 1); a function of bundle and seed. Rows by graph, then by name of the
// tap.
//
// Thread-safety: one caller per scratch folder. Blocking: computes; about two
// seconds for onnxruntime, however many graphs. Errors: those of the back ends,
// named.
absl::StatusOr<std::vector<ParityRow>> CompareBackEnds(
    const bundle::Bundle& bundle, const ParityOptions& options);

// INTERNAL naming the first graph, tap and back end beyond the tolerance.
absl::Status CheckParity(const std::vector<ParityRow>& rows);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PARITY_BUNDLE_PARITY_H_
