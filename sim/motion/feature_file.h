#ifndef SINEW_SIM_MOTION_FEATURE_FILE_H_
#define SINEW_SIM_MOTION_FEATURE_FILE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/mapped_file.h"
#include "common/policy/safetensors.h"
#include "sim/motion/library.h"

namespace sinew::motion {

// What a feature file is to hold.
struct FeatureKey {
  // The library that the numbers are computed from.
  const Library* library = nullptr;
  // Everything else that the numbers depend on, as text: what is computed, by
  // which version of the formulas, with which parameters.
  std::string definition;
  // Names and shapes of the tensors, all float32.
  std::map<std::string, std::vector<int64_t>> shapes;
};

// Numbers computed from a library once and kept beside it as a safetensors
// file, whose metadata names the library and the definition that it was
// computed from. A file that is not there, is not whole, or is of another
// library or definition is computed anew and replaced. Processes that open the
// same file share its memory; two that compute it at the same time write the
// same bytes.
//
//   file "vmp.features.safetensors": metadata {"library": SHA-256,
//   "definition": SHA-256 of the text}, tensors
//
// Where the folder cannot be written the numbers stay in memory, and the next
// process computes them again.
//
// Thread-safety: immutable. Ownership: owns the mapping or the numbers.
// Blocking: OpenOrCompute opens, or verifies the library and computes. Errors:
// those of Library::Verify and of `compute`; INTERNAL if what it gives has not
// the shapes of the key.
class FeatureFile {
 public:
  static absl::StatusOr<std::unique_ptr<const FeatureFile>> OpenOrCompute(
      const std::string& path, const FeatureKey& key,
      absl::FunctionRef<absl::StatusOr<TensorMap>()> compute);

  // Elements of a tensor of the key.
  absl::Span<const float> tensor(const std::string& name) const {
    return tensors_.at(name).float32();
  }
  // True if this call found the file.
  bool found() const { return found_; }
  // OK, or why the file could not be written; worth a line in a log.
  const absl::Status& kept() const { return kept_; }

 private:
  FeatureFile() = default;
  // True if the file at `path` is there and fits.
  bool Open(const std::string& path, const FeatureKey& key);

  std::unique_ptr<const MappedFile> file_;
  TensorMap computed_;  // where the folder cannot be written
  std::map<std::string, TensorView> tensors_;  // of one of the two
  bool found_ = false;
  absl::Status kept_;
};

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_FEATURE_FILE_H_
