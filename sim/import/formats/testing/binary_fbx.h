#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_BINARY_FBX_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_BINARY_FBX_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace sinew::import::testing {

struct BinaryFbxOptions {
  // 7400 has offsets of 32 bits, 7500 and later of 64.
  uint32_t version = 7400;
  // Arrays deflated, as most programs write them.
  bool deflate = true;
};

// The binary form of a text FBX file with one node or list of numbers a line,
// as the FBX library's exporter writes them: same nodes, same values, each of
// the type that the field has in the files of other programs. Aborts on text
// that is otherwise.
std::string BinaryFbx(absl::string_view text,
                      const BinaryFbxOptions& options = {});

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_BINARY_FBX_H_
