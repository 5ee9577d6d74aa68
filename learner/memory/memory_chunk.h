#ifndef SINEW_LEARNER_MEMORY_MEMORY_CHUNK_H_
#define SINEW_LEARNER_MEMORY_MEMORY_CHUNK_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "learner/learner.h"

namespace sinew::learner {

// Extents of every sequence of a memory, all >= 1.
struct SequenceShape {
  int64_t steps = 0;        // T
  int64_t observation = 0;  // O
  int64_t action = 0;       // A
};

// The labelled rows of one segment: E sequences, one per environment, of T
// consecutive steps. A row is linked if it goes on from the row before it in
// its sequence: the same episode, and both valid. The first row never is.
struct LabelledSequences {
  int64_t order_id = 0;
  std::vector<float> observation;  // [E, T, O], not normalised
  std::vector<float> label;   // [E, T, A], the student's units; 0 if not valid
  std::vector<float> valid;   // [E, T], 0 or 1: may be learnt from
  std::vector<float> linked;  // [E, T], 0 or 1
};

// The same, in somebody else's memory.
struct SequencesView {
  int64_t sequences = 0;                // E
  absl::Span<const float> observation;  // [E, T, O]
  absl::Span<const float> label;        // [E, T, A]
  absl::Span<const float> valid;        // [E, T]
  absl::Span<const float> linked;       // [E, T]
};

// A chunk's bytes: safetensors with the four arrays by these names, and
// metadata "order_id". Equal sequences give equal bytes.
//
// Pure functions: thread-safe, never blocking. MakeChunk CHECKs sizes.
StateChunk MakeChunk(const LabelledSequences& sequences,
                     const SequenceShape& shape);

// A view of the chunk's bytes, which must outlive it. DATA_LOSS naming chunk
// and what is wrong: digest, shapes, numbers that are not finite, flags that
// are not 0 or 1, links from rows that are not valid.
absl::StatusOr<SequencesView> ViewChunk(const StateChunk& chunk,
                                        const SequenceShape& shape);
// The same without computing the digest anew: of a chunk that MakeChunk has
// made in this process.
absl::StatusOr<SequencesView> ViewOwnChunk(const StateChunk& chunk,
                                           const SequenceShape& shape);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_MEMORY_MEMORY_CHUNK_H_
