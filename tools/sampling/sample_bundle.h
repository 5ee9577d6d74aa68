#ifndef SINEW_TOOLS_SAMPLING_SAMPLE_BUNDLE_H_
#define SINEW_TOOLS_SAMPLING_SAMPLE_BUNDLE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/stop.h"
#include "tools/sampling/sample_figures.h"

namespace sinew::sampling {

struct SamplingOptions {
  std::string bundle;
  std::string motions;              // library; empty: none
  std::string start;                // ParseStart; empty: see SampleBundle
  double seconds = 10;              // of each sample, > 0
  int count = 64;                   // samples at each scale of the noise
  int per_start = 0;                // of one start; 0: 4, 2 or 1, as it divides
  std::vector<double> noise = {1};  // scales, 0 to kMostNoise
  uint64_t seed = 0;                // of noise and clip frames, not of falls
  int threads = 1;                  // >= 1; never changes results
  double threshold = 0.5;           // of coverage, > 0
  int64_t transitions = 40000;      // that are compared at most, >= 1
  bool student = false;             // also what the policy itself covers
  std::string out;                  // JSON file; empty: none
  std::string pictures;             // folder; empty: none
  std::string page;                 // HTML file; empty: none
};

struct SamplingResult {
  std::vector<SampleFigures> ways;  // zero action, zero noise, then each scale
  std::vector<std::string> files;   // that were written
};

// Most control steps of one way to act: bounds the memory, about 1 kB each.
inline constexpr int64_t kMostSteps = 500000;

// Largest scale of the noise: far beyond what a decoder was trained on, and
// within what a float holds.
inline constexpr double kMostNoise = 1e6;

// What `sinew sample` does: lets the prior of a bundle move bodies from `start`
// (clip where there is a library, else fallen) at each scale of the noise, and,
// since figures flatter otherwise, at none, and with the zero action; measures,
// compares with the library, and writes those of `out`, page and pictures that
// are asked for. Same inputs, same bits, however many threads.
//
// Blocking: computes and waits for the disk, seconds to minutes. Errors:
// INVALID_ARGUMENT naming the flag, expected and found; those of ReadBundle,
// Sampler, MakeStarts, MakeLibraryTransitions, AddStudent and writing;
// CANCELLED.
absl::StatusOr<SamplingResult> SampleBundle(const SamplingOptions& options,
                                            const StopToken& stop);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SAMPLE_BUNDLE_H_
