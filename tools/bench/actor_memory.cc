#include "tools/bench/actor_memory.h"

#include <unistd.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::bench {
namespace {

// Bytes of this process that are in memory.
absl::StatusOr<double> ResidentBytes() {
  constexpr char kPath[] = "/proc/self/statm";
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(kPath, /*max_bytes=*/4096));
  const std::vector<std::string> fields = absl::StrSplit(text, ' ');
  int64_t pages = 0;
  if (fields.size() < 2 || !absl::SimpleAtoi(fields[1], &pages)) {
    return absl::NotFoundError(absl::StrCat(
        kPath, ": expected a second number, found ", fields.size(), " fields"));
  }
  return static_cast<double>(pages) *
         static_cast<double>(sysconf(_SC_PAGESIZE));
}

v1::Order MakeOrder(int environments, int horizon,
                    const actor::RolloutAssets& assets,
                    const actor::PreparedSnapshot& snapshot) {
  v1::Order order;
  order.set_run_id("bench");
  order.set_kind(v1::Order::KIND_TRAIN);
  order.set_snapshot_version(snapshot.version());
  order.set_snapshot_sha256(snapshot.sha256());
  order.set_layout_sha256(assets.layout_sha256());
  order.set_horizon(horizon);
  for (int e = 0; e < environments; ++e) order.add_states();
  return order;
}

}  // namespace

absl::StatusOr<MemoryFigures> MeasureMemory(
    int environments, int horizon,
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const v1::Snapshot& snapshot) {
  SINEW_ASSIGN_OR_RETURN(const double before, ResidentBytes());
  SINEW_ASSIGN_OR_RETURN(
      const auto prepared,
      actor::PreparedSnapshot::Create(
          snapshot, Sha256Hex(SerializeDeterministically(snapshot)), *assets));
  SINEW_ASSIGN_OR_RETURN(const auto worker,
                         actor::RolloutWorker::Create(assets, environments));
  SINEW_ASSIGN_OR_RETURN(
      const v1::Segment segment,
      worker->Run(MakeOrder(environments, horizon, *assets, *prepared),
                  *prepared));
  SINEW_ASSIGN_OR_RETURN(const double after, ResidentBytes());
  const double bytes = std::max(0.0, after - before);
  return MemoryFigures{.environments = environments,
                       .actor_mb = bytes / 1e6,
                       .per_environment_kb = bytes / 1e3 / environments};
}

}  // namespace sinew::bench
