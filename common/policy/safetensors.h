#ifndef SINEW_COMMON_POLICY_SAFETENSORS_H_
#define SINEW_COMMON_POLICY_SAFETENSORS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/tensor.pb.h"

namespace sinew {

// One array in host memory, row-major, little-endian.
struct HostTensor {
  v1::DataType dtype = v1::DATA_TYPE_FLOAT32;
  std::vector<int64_t> shape;
  std::string data;

  int64_t num_elements() const;
  // Elements as float32 / float64. Precondition: dtype matches (CHECKed).
  absl::Span<const float> float32() const;
  absl::Span<float> mutable_float32();
  absl::Span<const double> float64() const;

  static HostTensor Float32(std::vector<int64_t> shape,
                            absl::Span<const float> values);
  static HostTensor Float64(std::vector<int64_t> shape,
                            absl::Span<const double> values);
  static HostTensor Zeros(std::vector<int64_t> shape);  // float32
};

// Tensors by name, sorted; what a safetensors file holds.
using TensorMap = std::map<std::string, HostTensor>;

// The safetensors format (8-byte little-endian header length, JSON header,
// data), tensors sorted by name, header padded with spaces to 8 bytes: equal
// maps give equal bytes. `metadata` becomes "__metadata__".
std::string SerializeSafetensors(
    const TensorMap& tensors,
    const std::map<std::string, std::string>& metadata = {});

// Total: any bytes give a map or an error that says what is wrong (header
// length, JSON, overlapping or out-of-range offsets, wrong size, unknown
// dtype), without allocating more than the input's size. `source` names the
// file or peer in errors. Non-finite numbers are NOT checked here.
absl::StatusOr<TensorMap> ParseSafetensors(absl::string_view bytes,
                                           absl::string_view source);

// One array in somebody else's memory, e.g. a mapped file; as HostTensor
// otherwise.
struct TensorView {
  v1::DataType dtype = v1::DATA_TYPE_FLOAT32;
  std::vector<int64_t> shape;
  absl::string_view data;

  // Whether data lies where its numbers may be read: at a multiple of 4 bytes.
  bool aligned() const;
  // Elements as float32. Precondition: dtype matches, aligned() (CHECKed).
  absl::Span<const float> float32() const;
};

// Tensors by name, sorted, with the file's "__metadata__".
struct SafetensorsView {
  std::map<std::string, TensorView> tensors;
  std::map<std::string, std::string> metadata;
};

// As ParseSafetensors, but copies nothing: the result points into `bytes`, of
// which only the header is read. Data lies where the file has it: of a file of
// ours at a multiple of 8 bytes from the beginning.
absl::StatusOr<SafetensorsView> ViewSafetensors(absl::string_view bytes,
                                                absl::string_view source);

// Views of `tensors`, which must outlive them.
std::map<std::string, TensorView> ViewTensors(const TensorMap& tensors);

// Byte offset and length of a tensor's data within the serialised file, for
// ONNX external data. NOT_FOUND.
struct TensorLocation {
  int64_t offset = 0;
  int64_t length = 0;
};
absl::StatusOr<std::map<std::string, TensorLocation>> LocateSafetensors(
    absl::string_view bytes, absl::string_view source);

// INVALID_ARGUMENT naming the first tensor and element that is NaN or
// infinite.
absl::Status CheckFinite(const TensorMap& tensors, absl::string_view source);

}  // namespace sinew

#endif  // SINEW_COMMON_POLICY_SAFETENSORS_H_
