#include "sim/motion/feature_file.h"

#include <utility>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::motion {
namespace {

std::map<std::string, std::string> Metadata(const FeatureKey& key) {
  return {{"library", key.library->digest()},
          {"definition", Sha256Hex(key.definition)}};
}

bool HasShapes(const std::map<std::string, TensorView>& tensors,
               const FeatureKey& key) {
  if (tensors.size() != key.shapes.size()) return false;
  for (const auto& [name, shape] : key.shapes) {
    const auto found = tensors.find(name);
    if (found == tensors.end()) return false;
    const TensorView& tensor = found->second;
    if (tensor.dtype != v1::DATA_TYPE_FLOAT32 || tensor.shape != shape ||
        !tensor.aligned()) {
      return false;
    }
  }
  return true;
}

}  // namespace

bool FeatureFile::Open(const std::string& path, const FeatureKey& key) {
  auto file = MappedFile::Open(path);
  if (!file.ok()) return false;
  auto view = ViewSafetensors((*file)->bytes(), path);
  if (!view.ok() || view->metadata != Metadata(key) ||
      !HasShapes(view->tensors, key)) {
    return false;
  }
  file_ = *std::move(file);
  tensors_ = std::move(view->tensors);
  return true;
}

absl::StatusOr<std::unique_ptr<const FeatureFile>> FeatureFile::OpenOrCompute(
    const std::string& path, const FeatureKey& key,
    absl::FunctionRef<absl::StatusOr<TensorMap>()> compute) {
  auto features = absl::WrapUnique(new FeatureFile());
  features->found_ = features->Open(path, key);
  if (features->found_) return features;
  // What is kept under the library's digest must be of its frames.
  SINEW_RETURN_IF_ERROR(key.library->Verify());
  SINEW_ASSIGN_OR_RETURN(TensorMap computed, compute());
  if (!HasShapes(ViewTensors(computed), key)) {
    return absl::InternalError(
        absl::StrCat(path, ": expected tensors of other names or shapes from ",
                     "the computation of ", key.definition));
  }
  features->kept_ =
      WriteFileAtomically(path, SerializeSafetensors(computed, Metadata(key)));
  // Another process may have put another definition's numbers there meanwhile.
  if (features->kept_.ok() && features->Open(path, key)) return features;
  features->computed_ = std::move(computed);
  features->tensors_ = ViewTensors(features->computed_);
  return features;
}

}  // namespace sinew::motion
