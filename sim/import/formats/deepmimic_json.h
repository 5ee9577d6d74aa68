#ifndef SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_JSON_H_
#define SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_JSON_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// The two keys of a DeepMimic file that matter, as written there.
struct DeepMimicFile {
  bool loops = false;
  std::vector<std::vector<double>> frames;
};

// Reads the JSON by events, so that nothing else of the file is kept.
// INVALID_ARGUMENT naming `source`: not JSON (with the position), no object at
// the top, "Loop" other than "wrap" or "none" (absent: none), no "Frames" or
// not an array of arrays of numbers.
absl::StatusOr<DeepMimicFile> ReadDeepMimicJson(absl::string_view json,
                                                absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_DEEPMIMIC_JSON_H_
