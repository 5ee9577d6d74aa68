// Lets the prior alone move the body in MuJoCo, from where the library's first
// clip begins: sample BUNDLE LIBRARY [SECONDS [NOISE]].
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"

namespace {

using sinew::runtime::Runtime;
using sinew::runtime::Simulation;

// N(0, 1) times `scale`; 0: always what the prior thinks likeliest.
void Draw(uint64_t step, double scale, std::vector<double>& noise) {
  std::vector<float> normal(noise.size());
  sinew::FillNormal(
      {.seed = 1, .step = step, .purpose = sinew::RandomPurpose::kAction},
      absl::MakeSpan(normal));
  for (size_t i = 0; i < noise.size(); ++i) noise[i] = scale * normal[i];
}

absl::Status Sample(const char* bundle, const char* library, double seconds,
                    double scale) {
  SINEW_ASSIGN_OR_RETURN(const auto policy, Runtime::Open(bundle));
  SINEW_RETURN_IF_ERROR(policy->LoadLibrary(library));
  SINEW_RETURN_IF_ERROR(policy->Play(policy->library()->clip(0).name(), 0,
                                     Runtime::Align::kNone));
  Simulation body(*policy);
  SINEW_RETURN_IF_ERROR(body.Start(*policy));
  std::vector<double> noise(policy->latent_width());
  for (int step = 0; step < seconds * policy->control_hz(); ++step) {
    Draw(step, scale, noise);
    SINEW_RETURN_IF_ERROR(policy->Sample(body.pose(), noise, body.target()));
    SINEW_RETURN_IF_ERROR(body.Step());
  }
  std::printf("%.1f s by the prior, %d numbers a step, root at %.2f m\n",
              seconds, policy->latent_width(), body.data().qpos[2]);
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: sample BUNDLE LIBRARY [SECONDS [NOISE]]\n");
    return 2;
  }
  const absl::Status status =
      Sample(argv[1], argv[2], argc > 3 ? std::atof(argv[3]) : 10,
             argc > 4 ? std::atof(argv[4]) : 1);
  if (!status.ok()) {
    std::fprintf(stderr, "sample: %s\n", status.ToString().c_str());
  }
  return status.ok() ? 0 : 1;
}
