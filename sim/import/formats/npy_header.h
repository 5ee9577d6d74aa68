#ifndef SINEW_SIM_IMPORT_FORMATS_NPY_HEADER_H_
#define SINEW_SIM_IMPORT_FORMATS_NPY_HEADER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// What the header of a NumPy array file says (npy, versions 1 to 3; the format
// is documented with numpy.lib.format).
struct NpyHeader {
  enum class Kind { kFloat, kInt, kUnsigned, kBool, kUnicode, kBytes };

  Kind kind = Kind::kFloat;
  int64_t item_bytes = 0;  // of one element; 4 a character of kUnicode
  bool big_endian = false;
  bool fortran_order = false;
  std::vector<int64_t> shape;  // empty: one element (0-d)
  int64_t data_offset = 0;     // bytes before the first element

  bool is_text() const {
    return kind == Kind::kUnicode || kind == Kind::kBytes;
  }
  int64_t count() const;  // elements
  int64_t total_bytes() const { return data_offset + count() * item_bytes; }
  // "float32 (119, 72)".
  std::string ToString() const;
};

// Bytes from the start of a file that hold any header that is accepted.
inline constexpr int64_t kNpyMaxHeaderBytes = 16 << 10;
// Larger arrays are refused.
inline constexpr int64_t kNpyMaxBytes = int64_t{1} << 30;

// Reads the header at the start of `bytes` (at least the first
// kNpyMaxHeaderBytes of the file, or all of it). Strict: the three keys and no
// others. INVALID_ARGUMENT naming `source`, expected and found: not npy, other
// versions, pickled objects, records, complex numbers and dates, shapes of more
// than 4 dimensions. RESOURCE_EXHAUSTED: more than kNpyMaxBytes.
absl::StatusOr<NpyHeader> ParseNpyHeader(absl::string_view bytes,
                                         absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_NPY_HEADER_H_
