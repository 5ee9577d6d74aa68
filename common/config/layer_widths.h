#ifndef SINEW_COMMON_CONFIG_LAYER_WIDTHS_H_
#define SINEW_COMMON_CONFIG_LAYER_WIDTHS_H_

#include <cstdint>

#include "absl/strings/string_view.h"
#include "common/config/field_checker.h"
#include "google/protobuf/repeated_field.h"

namespace sinew {

// Widths of a network's hidden layers: each within [1, 16384]. Thread-safety:
// pure. Blocking: never. Errors: in `check`.
inline void CheckLayerWidths(
    const google::protobuf::RepeatedField<int32_t>& widths,
    absl::string_view path, FieldChecker& check) {
  constexpr int kMaxWidth = 16384;
  for (const int width : widths) check.Within(width, 1, kMaxWidth, path);
}

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_LAYER_WIDTHS_H_
