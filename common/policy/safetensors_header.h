#ifndef SINEW_COMMON_POLICY_SAFETENSORS_HEADER_H_
#define SINEW_COMMON_POLICY_SAFETENSORS_HEADER_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/tensor.pb.h"

namespace sinew::internal {

// One tensor as a safetensors header states it. Offsets are relative to the
// first byte after the header.
struct SafetensorsEntry {
  std::string name;
  v1::DataType dtype = v1::DATA_TYPE_UNSPECIFIED;
  std::vector<int64_t> shape;
  int64_t begin = 0;
  int64_t end = 0;
};

// A header that has been checked against the size of the file: the entries,
// sorted by offset, tile the data without gap or overlap, and each holds
// exactly as many bytes as dtype and shape ask for.
struct SafetensorsLayout {
  std::vector<SafetensorsEntry> entries;
  // "__metadata__"; of a key that appears twice the last value.
  std::map<std::string, std::string> metadata;
  // First byte of the data within the file.
  int64_t data_offset = 0;
};

// Largest number of extents of a tensor.
inline constexpr int kMaxSafetensorsRank = 8;

// Bytes of one element; 0 for a type that is no element type.
int64_t DataTypeSize(v1::DataType dtype);

// Name in a safetensors header ("F32"); empty for a type without one.
absl::string_view SafetensorsTypeName(v1::DataType dtype);

// Reads the header of a safetensors file image. Total: any bytes give a layout
// or INVALID_ARGUMENT saying what is wrong, prefixed by `source`. Allocates in
// proportion to the header's size.
absl::StatusOr<SafetensorsLayout> ParseSafetensorsLayout(
    absl::string_view bytes, absl::string_view source);

}  // namespace sinew::internal

#endif  // SINEW_COMMON_POLICY_SAFETENSORS_HEADER_H_
