// Runs one order in a process of its own:
//
//   rollout_process FOLDER THREADS
//
// FOLDER holds what an actor would fetch: "order" and "snapshot" (serialised),
// and each asset in a file named by its role. So many threads run the order at
// once, each with a worker of its own; thread i writes its segment, without
// seconds, to FOLDER/segment-i.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::actor {
namespace {

struct Inputs {
  v1::Order order;
  std::shared_ptr<const RolloutAssets> assets;
  std::shared_ptr<const PreparedSnapshot> snapshot;
};

absl::StatusOr<Inputs> ReadInputs(const std::string& folder) {
  std::vector<std::string> bytes;
  for (const char* role : {"character", "model", "library", "frames", "recipe",
                           "order", "snapshot"}) {
    SINEW_ASSIGN_OR_RETURN(bytes.emplace_back(),
                           ReadFile(JoinPath(folder, role)));
  }
  Inputs inputs;
  v1::Snapshot snapshot;
  if (!inputs.order.ParseFromString(bytes[5]) ||
      !snapshot.ParseFromString(bytes[6])) {
    return absl::InvalidArgumentError("order or snapshot does not parse");
  }
  SINEW_ASSIGN_OR_RETURN(
      inputs.assets,
      RolloutAssets::Create(bytes[0], bytes[1], bytes[2], bytes[3], bytes[4]));
  SINEW_ASSIGN_OR_RETURN(
      inputs.snapshot,
      PreparedSnapshot::Create(snapshot, Sha256Hex(bytes[6]), *inputs.assets));
  return inputs;
}

absl::Status RunOrder(const Inputs& inputs, const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<RolloutWorker> worker,
                         RolloutWorker::Create(inputs.assets, 4));
  SINEW_ASSIGN_OR_RETURN(v1::Segment segment,
                         worker->Run(inputs.order, *inputs.snapshot));
  segment.clear_seconds();
  return WriteFileAtomically(path, SerializeDeterministically(segment));
}

absl::Status RunOnThreads(const std::string& folder, int count) {
  SINEW_ASSIGN_OR_RETURN(const Inputs inputs, ReadInputs(folder));
  std::vector<absl::Status> statuses(count);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < count; ++i) {
      threads.emplace_back([&, i] {
        statuses[i] =
            RunOrder(inputs, JoinPath(folder, absl::StrCat("segment-", i)));
      });
    }
  }
  absl::Status status;
  for (const absl::Status& each : statuses) status.Update(each);
  return status;
}

}  // namespace
}  // namespace sinew::actor

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const absl::Status status =
      sinew::actor::RunOnThreads(argv[1], std::atoi(argv[2]));
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}
