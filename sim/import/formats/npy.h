#ifndef SINEW_SIM_IMPORT_FORMATS_NPY_H_
#define SINEW_SIM_IMPORT_FORMATS_NPY_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/npy_header.h"

namespace sinew::import {

// An array as it lies in the file.
//
// Thread-safety: immutable. Ownership: owns the bytes. Blocking: never. Errors:
// Parse, Text.
class NpyArray {
 public:
  // All of a file. INVALID_ARGUMENT as ParseNpyHeader, or if the size is not
  // the one that the header asks for.
  static absl::StatusOr<NpyArray> Parse(std::string bytes,
                                        absl::string_view source);

  const NpyHeader& header() const { return header_; }
  const std::vector<int64_t>& shape() const { return header_.shape; }
  int64_t count() const { return header_.count(); }

  // Element by its index in C order, whatever the order in the file.
  // Preconditions: not text; 0 <= index < count().
  double Number(int64_t index) const;

  // The only element of an array of text, as UTF-8. INVALID_ARGUMENT naming
  // `source` unless it is that.
  absl::StatusOr<std::string> Text(absl::string_view source) const;

 private:
  NpyArray(NpyHeader header, std::string bytes)
      : header_(std::move(header)), bytes_(std::move(bytes)) {}

  NpyHeader header_;
  std::string bytes_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_NPY_H_
