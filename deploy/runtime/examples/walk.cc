// Walks in MuJoCo: walk BUNDLE LIBRARY [SECONDS].
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "absl/status/status.h"
#include "common/status_macros.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"

namespace {

using sinew::runtime::Runtime;
using sinew::runtime::Simulation;

absl::Status Walk(const char* bundle, const char* library, double seconds) {
  SINEW_ASSIGN_OR_RETURN(const auto policy, Runtime::Open(bundle));
  SINEW_RETURN_IF_ERROR(policy->LoadLibrary(library));
  const std::string clip = policy->library()->clip(0).name();
  SINEW_RETURN_IF_ERROR(policy->Play(clip, 0, Runtime::Align::kNone));
  Simulation body(*policy);
  SINEW_RETURN_IF_ERROR(body.Start(*policy));
  const mjtNum x = body.data().qpos[0], y = body.data().qpos[1];
  for (int step = 0; step < seconds * policy->control_hz(); ++step) {
    SINEW_RETURN_IF_ERROR(policy->Step(body.pose(), body.target()));
    SINEW_RETURN_IF_ERROR(body.Step());
  }
  const mjtNum* root = body.data().qpos;
  std::printf("%s: walked %.2f m in %.1f s, root at %.2f m\n", clip.c_str(),
              std::hypot(root[0] - x, root[1] - y), seconds, root[2]);
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: walk BUNDLE LIBRARY [SECONDS]\n");
    return 2;
  }
  const absl::Status status =
      Walk(argv[1], argv[2], argc > 3 ? std::atof(argv[3]) : 10);
  if (!status.ok())
    std::fprintf(stderr, "walk: %s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
