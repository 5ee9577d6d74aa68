#ifndef SINEW_TOOLS_SAMPLING_SHOWN_SAMPLES_H_
#define SINEW_TOOLS_SAMPLING_SHOWN_SAMPLES_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"
#include "sim/character/character.h"
#include "tools/sampling/sample_figures.h"
#include "tools/sampling/sampling_json.h"

namespace sinew::sampling {

// Samples of one way to act that are to be seen.
struct ShownWay {
  std::string name;  // SampleFigures::name
  struct Sample {
    std::string start;
    std::vector<double> qpos;  // [frames, nq]
  };
  std::vector<Sample> samples;
};

// A film strip (PNG) of every sample into `folder`, which is made: files like
// noise_1-0.png; returns their paths. Blocking: draws, half a second each.
// Errors: those of tools/render (UNAVAILABLE without OpenGL), CANCELLED.
absl::StatusOr<std::vector<std::string>> WritePictures(
    const character::Character& character, double frames_per_second,
    const std::vector<ShownWay>& ways, const std::string& folder,
    const StopToken& stop);

// One self-contained page with the figures and a viewer that plays the samples
// of a way side by side: that of tools/motion_report. Errors: INVALID_ARGUMENT
// for samples without frames.
absl::StatusOr<std::string> SamplesPage(
    const character::Character& character, const SamplingSource& source,
    const std::vector<SampleFigures>& figures,
    const std::vector<ShownWay>& ways);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SHOWN_SAMPLES_H_
