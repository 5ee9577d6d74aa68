#ifndef SINEW_TOOLS_TRAINING_COMPACT_STATE_H_
#define SINEW_TOOLS_TRAINING_COMPACT_STATE_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "learner/trainer/trainer.h"
#include "proto/sinew/v1/run.pb.h"

namespace sinew::tools {

// What of a run another machine needs to train on: a folder that is a store
// (deploy/checkpoint/local_store.h) of one artifact of kind "state":
//
//   state.pb, tensors.safetensors   learner/state/state_files.h: weights,
//                                   optimisers, normaliser, counters, table of
//                                   clips; no environments under way, orders,
//                                   snapshots, or chunks of a distillation's
//                                   memory; rows counted so far stay
//   assets.pb                       v1::TaskAssets: digests of character,
//                                   recipe and library it was trained with
//   sources.pb                      v1::RunInputs with `sources` alone: the
//                                   bundles that the run began with and learns
//                                   from
//
// A run goes on from it by Trainer::Migrate: environments begin new episodes,
// so its bits are not those of the run that was not moved.
struct CompactState {
  learner::Trainer::State state;
  std::map<std::string, std::string> assets;  // SHA-256 by role
  // Unset: written before there were any.
  std::optional<std::vector<v1::RunInputs::Source>> sources;
};

// Of a state, what a compact one holds. Pure.
learner::Trainer::State Compact(const learner::Trainer::State& state);

// Writes the newest state in a run's store to a new folder, with `sources` of
// the run's inputs. Blocks on store and disk. Errors: ALREADY_EXISTS: the
// folder is there; those of LoadLatestState; DATA_LOSS: the run's assets are
// not listed.
absl::Status WriteCompactState(checkpoint::ArtifactStore& from,
                               const std::string& folder, const Clock& clock,
                               absl::Span<const v1::RunInputs::Source> sources);

// Blocks on the disk. Errors: NOT_FOUND: there is no such folder or state in
// it; DATA_LOSS: it is damaged.
absl::StatusOr<CompactState> ReadCompactState(const std::string& folder,
                                              const Clock& clock);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_COMPACT_STATE_H_
