#include "tools/report/core_seconds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/json_fields.h"

namespace sinew::report {
namespace {

struct StageName {
  const char* name;
  const char* what;
};

// Keys of "seconds" whose values are seconds of one thread.
constexpr std::array<StageName, 9> kStages = {{
    {"simulate", "MuJoCo steps"},
    {"infer", "the policy's forward passes"},
    {"observe", "observation, reward, termination"},
    {"encode", "packing segments"},
    {"label", "waiting for the teacher"},
    {"learn", "gradients and optimiser"},
    {"evaluate", "rollouts of evaluations"},
    {"publish", "making and handing out snapshots"},
    {"save", "writing states"},
}};

// Learning runs on `ranks` threads at once, and while labels are waited for
// nothing else runs; their seconds are wall time.
double Threads(const std::string& stage, const Json& row, double cores) {
  if (stage == "label") return std::max(1.0, cores);
  return stage == "learn" ? NumberAt(row, {"ranks"}, std::max(1.0, cores)) : 1;
}

// Cores if rows do not say: as many as kept busy while the learner waited.
double GuessCores(const std::vector<Json>& rows) {
  double busy = 0, waited = 0;
  for (const Json& row : rows) {
    for (const char* name :
         {"simulate", "infer", "observe", "encode", "evaluate"}) {
      busy += NumberAt(row, {"seconds", name});
    }
    waited += NumberAt(row, {"seconds", "wait"});
  }
  return waited > 0 ? std::max(1.0, std::ceil(busy / waited - 0.05)) : 0;
}

}  // namespace

CoreSeconds CountCoreSeconds(const std::vector<Json>& rows) {
  CoreSeconds result;
  for (const Json& row : rows) {
    result.cores = std::max(result.cores, NumberAt(row, {"cores"}));
  }
  if (result.cores == 0) result.cores = GuessCores(rows);
  std::array<double, kStages.size()> seconds{};
  double last_wall = 0;
  for (const Json& row : rows) {
    const double wall = NumberAt(row, {"wall_s"}, last_wall);
    const double elapsed = std::max(0.0, wall - last_wall);
    last_wall = wall;
    if (!row.contains("seconds")) continue;
    result.wall += elapsed;
    for (size_t i = 0; i < kStages.size(); ++i) {
      seconds[i] += NumberAt(row, {"seconds", kStages[i].name}) *
                    Threads(kStages[i].name, row, result.cores);
    }
  }
  for (size_t i = 0; i < kStages.size(); ++i) {
    if (seconds[i] <= 0) continue;
    result.stages.push_back({kStages[i].name, kStages[i].what, seconds[i]});
    result.total += seconds[i];
  }
  const double idle = result.cores * result.wall - result.total;
  if (idle > 0) {
    result.stages.push_back({"wait", "idle, waiting, or lent to others", idle});
    result.total += idle;
  }
  return result;
}

}  // namespace sinew::report
