#ifndef SINEW_TOOLS_SAMPLING_SAMPLING_JSON_H_
#define SINEW_TOOLS_SAMPLING_SAMPLING_JSON_H_

#include <cstdint>
#include <string>
#include <vector>

#include "tools/sampling/library_transitions.h"
#include "tools/sampling/sample_figures.h"

namespace sinew::sampling {

// What was asked for, and what of a bundle.
struct SamplingSource {
  std::string bundle;
  std::string manifest_sha256;
  std::string character;
  std::string motions;         // empty: none
  std::string library_sha256;  // Library::digest(); empty: none
  std::string start;           // as `--start` said
  double seconds = 0;
  uint64_t seed = 0;
  double control_hz = 0;
  // Body whose height says what is upright, and its standing height, m.
  std::string upright_body;
  double standing_height = 0;
  int features = 0;  // F of transitions
  double threshold = 0;
  // Whether the bundle's evaluations, in which the student moves, are.
  bool student_randomised = false;
};

// The file of `sinew sample`; what its fields mean it says itself under
// "definitions". Shares and means of nothing are null. `library` may be null.
// Pure.
std::string SamplingJson(const SamplingSource& source,
                         const LibraryTransitions* library,
                         const std::vector<SampleFigures>& figures);

// The same for a terminal: a heading and a line per way to act, in columns.
std::string SamplingTable(const std::vector<SampleFigures>& figures);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SAMPLING_JSON_H_
