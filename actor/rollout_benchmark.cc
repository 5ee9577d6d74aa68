// Where the time of a training rollout goes, and the memory it needs:
//
//   rollout_benchmark CHARACTER LIBRARY RECIPE [ENVIRONMENTS [ORDERS]]
//
// Runs orders of 32 control steps of the recipe's freshly initialised policy on
// one thread; reports microseconds of a control step by stage, and the resident
// memory of the process. Recipe: a file.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::actor {
namespace {

constexpr int kHorizon = 32;

struct Options {
  std::string character, library, recipe;
  int environments = 8;
  int orders = 40;
};

absl::StatusOr<std::shared_ptr<const RolloutAssets>> LoadAssets(
    const Options& options) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(options.recipe));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe recipe, ParseRecipe(text, options.recipe));
  recipe = WithDefaults(std::move(recipe));
  SINEW_ASSIGN_OR_RETURN(
      auto character,
      character::Character::Load(options.character, recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(auto library, motion::Library::Load(options.library));
  return RolloutAssets::FromParts(recipe, std::move(character),
                                  std::move(library));
}

absl::StatusOr<std::shared_ptr<const PreparedSnapshot>> MakeSnapshot(
    const RolloutAssets& assets) {
  policy::TrackingPolicyOptions options;
  options.observation_width = assets.task().observation_width();
  options.action_width = assets.task().action_width();
  options.network = assets.recipe().network();
  v1::Snapshot snapshot;
  SINEW_ASSIGN_OR_RETURN(*snapshot.mutable_graph(),
                         policy::BuildTrackingPolicy(options));
  SINEW_ASSIGN_OR_RETURN(const TensorMap weights,
                         policy::InitialWeights(options, /*seed=*/1));
  snapshot.set_weights(SerializeSafetensors(weights));
  return PrepareSnapshot(snapshot,
                         Sha256Hex(SerializeDeterministically(snapshot)),
                         assets);
}

double ResidentMegabytes() {
  const auto text = ReadFile("/proc/self/statm", 1 << 12);
  long pages = 0, resident = 0;
  if (!text.ok() ||
      std::sscanf(text->c_str(), "%ld %ld", &pages, &resident) != 2) {
    return 0;
  }
  return static_cast<double>(resident) * 4096 / 1e6;
}

absl::Status Run(const Options& options) {
  SINEW_ASSIGN_OR_RETURN(const auto assets, LoadAssets(options));
  SINEW_ASSIGN_OR_RETURN(const auto snapshot, MakeSnapshot(*assets));
  SINEW_ASSIGN_OR_RETURN(const auto worker,
                         RolloutWorker::Create(assets, options.environments));
  v1::Order order;
  order.set_kind(v1::Order::KIND_TRAIN);
  order.set_snapshot_sha256(snapshot->sha256());
  order.set_layout_sha256(assets->layout_sha256());
  order.set_horizon(kHorizon);
  for (int e = 0; e < options.environments; ++e) order.add_states();
  v1::StageSeconds sum;
  double encode = 0, total = 0, bytes = 0;
  for (int i = 0; i < options.orders; ++i) {
    const auto start = std::chrono::steady_clock::now();
    SINEW_ASSIGN_OR_RETURN(v1::Segment segment, worker->Run(order, *snapshot));
    const auto ran = std::chrono::steady_clock::now();
    bytes = static_cast<double>(segment.SerializeAsString().size());
    const auto end = std::chrono::steady_clock::now();
    *order.mutable_states() = segment.end_states();
    sum.set_simulate(sum.simulate() + segment.seconds().simulate());
    sum.set_infer(sum.infer() + segment.seconds().infer());
    sum.set_observe(sum.observe() + segment.seconds().observe());
    encode += std::chrono::duration<double>(end - ran).count();
    total += std::chrono::duration<double>(end - start).count();
  }
  const double us = 1e6 / (static_cast<double>(options.orders) * kHorizon *
                           options.environments);
  std::printf(
      "us per control step: simulate %.2f  infer %.2f  observe %.2f  "
      "encode %.2f  rest %.2f  (simulate %.1f %%)\n"
      "%.0f bytes a segment; resident %.1f MB\n",
      us * sum.simulate(), us * sum.infer(), us * sum.observe(), us * encode,
      us * (total - sum.simulate() - sum.infer() - sum.observe() - encode),
      100 * sum.simulate() / total, bytes, ResidentMegabytes());
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew::actor

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr,
                 "usage: rollout_benchmark CHARACTER LIBRARY RECIPE "
                 "[ENVIRONMENTS [ORDERS]]\n");
    return 2;
  }
  sinew::actor::Options options;
  options.character = argv[1];
  options.library = argv[2];
  options.recipe = argv[3];
  if (argc > 4) options.environments = std::max(1, std::atoi(argv[4]));
  if (argc > 5) options.orders = std::max(1, std::atoi(argv[5]));
  const absl::Status status = sinew::actor::Run(options);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}
