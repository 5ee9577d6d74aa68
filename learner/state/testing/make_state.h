#ifndef SINEW_LEARNER_STATE_TESTING_MAKE_STATE_H_
#define SINEW_LEARNER_STATE_TESTING_MAKE_STATE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// A small state after some iterations, with one snapshot; `values` floats, all
// different, in "weight".
inline Trainer::State MakeState(int64_t iteration, int64_t values = 6) {
  Trainer::State state;
  state.counters.set_format_version(1);
  state.counters.set_iteration(iteration);
  state.counters.set_samples(100 * iteration);
  auto& reference = *state.counters.add_snapshots();
  reference.set_version(iteration);
  state.snapshots.push_back(absl::StrCat("snapshot of ", iteration));
  reference.set_sha256(Sha256Hex(state.snapshots.back()));
  std::vector<float> weight(values);
  for (int64_t i = 0; i < values; ++i) {
    weight[i] = static_cast<float>(iteration + i);
  }
  state.tensors["weight"] = HostTensor::Float32({values}, weight);
  return state;
}

// Adds a chunk of memory with these bytes.
inline void AddChunk(const std::string& bytes, Trainer::State& state) {
  const std::string sha256 = Sha256Hex(bytes);
  state.counters.mutable_memory()->add_chunks()->set_sha256(sha256);
  state.chunks.push_back({sha256, std::make_shared<const std::string>(bytes)});
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_TESTING_MAKE_STATE_H_
