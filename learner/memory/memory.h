#ifndef SINEW_LEARNER_MEMORY_MEMORY_H_
#define SINEW_LEARNER_MEMORY_MEMORY_H_

#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "learner/learner.h"
#include "learner/memory/memory_chunk.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// What was seen and labelled, kept beyond its iteration: immutable chunks, one
// per segment, the oldest dropped once there are more than `rows` rows in all.
//
//   Insert ... Insert             the segments of an iteration
//   DueMinibatches                what the samples-to-insert ratio allows now
//   per minibatch: Select, At     whole sequences, with replacement
//                  SetPriority    of each, from its loss
//                  CountSampled
//
// With I rows inserted and S rows sampled so far, minibatches of M rows are
// due while S + M <= samples_per_insert * I. For example, 4 samples per insert
// and M = 2048: an iteration of 4096 rows allows 8 minibatches.
//
// UNIFORM draws every sequence alike; PRIORITISED with probability ~
// priority ^ exponent, where a new sequence has the largest priority that there
// is, and one without a valid row has none. Draws are functions of (seed, draw,
// what is there).
//
// Thread-safety: one caller; At from any thread while nothing else is called.
// Ownership: shares chunks' bytes. Blocking: never; Restore computes digests of
// all chunks. Errors: Restore, with nothing changed.
class Memory {
 public:
  struct Options {
    uint64_t seed = 0;
    SequenceShape shape;
    double samples_per_insert = 1;
    v1::Distillation::Memory recipe;  // defaults filled
  };
  explicit Memory(Options options) : options_(std::move(options)) {}

  // One sequence; valid until the next Insert or Restore.
  struct Reference {
    int32_t chunk = 0;     // from the oldest
    int32_t sequence = 0;  // within the chunk
  };
  // Its T rows.
  struct Sequence {
    absl::Span<const float> observation;  // [T, O]
    absl::Span<const float> label;        // [T, A]
    absl::Span<const float> valid;        // [T]
    absl::Span<const float> linked;       // [T]
  };

  // Precondition: made by MakeChunk, of this shape (CHECKed, but for the
  // digest).
  void Insert(int64_t order_id, StateChunk chunk);
  int64_t DueMinibatches(int64_t minibatch_rows) const;
  // Empty if there is nothing to draw from.
  std::vector<Reference> Select(int64_t count, uint64_t draw) const;
  Sequence At(Reference reference) const;
  // `priority` >= 0 and finite, 0 for the least that leaves it to be drawn at
  // all; ignored where the selector is UNIFORM.
  void SetPriority(Reference reference, float priority);
  void CountSampled(int64_t rows) { sampled_rows_ += rows; }

  int64_t rows() const { return sequences_ * options_.shape.steps; }
  int64_t inserted_rows() const { return inserted_rows_; }
  int64_t sampled_rows() const { return sampled_rows_; }

  void Save(v1::MemoryState& state) const;
  std::vector<StateChunk> chunks() const;  // oldest first
  // DATA_LOSS naming the chunk, or the field of the state, that is wrong.
  absl::Status Restore(const v1::MemoryState& state,
                       absl::Span<const StateChunk> chunks);

 private:
  struct Held {
    StateChunk chunk;
    int64_t order_id = 0;
    SequencesView view;
    std::vector<float> priorities;  // [E]
  };

  bool prioritised() const {
    return options_.recipe.selector() ==
           v1::Distillation::Memory::SELECTOR_PRIORITISED;
  }
  // Of every sequence, oldest first.
  std::vector<double> Weights() const;
  float LargestPriority() const;

  const Options options_;
  std::deque<Held> held_;  // oldest first
  int64_t sequences_ = 0;  // in all
  int64_t inserted_rows_ = 0;
  int64_t sampled_rows_ = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_MEMORY_MEMORY_H_
