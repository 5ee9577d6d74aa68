#ifndef SINEW_COMMON_RANDOM_PHILOX_H_
#define SINEW_COMMON_RANDOM_PHILOX_H_

#include <cstdint>

#include "absl/types/span.h"

namespace sinew {

// What a random number is for. Part of the key, so that two uses never share
// numbers. Values are part of the reproducibility contract: never renumber.
enum class RandomPurpose : uint32_t {
  kStart = 1,           // clip and frame of an episode's start
  kStartNoise = 2,      // noise on the start state
  kAction = 3,          // noise inputs of the policy graph
  kModelField = 4,      // randomised model fields
  kInitialisation = 5,  // initial weights
  kShuffle = 6,         // order of minibatch rows
  kRecovery = 20,       // kind and place of an episode's start
  kPush = 21,           // forces on the body
  kFallenState = 22,    // how a body is dropped
  kTeacher = 30,        // who acts in an episode
  kSelection = 31,      // sequences of a minibatch (learner/memory)
  kLatentNoise = 32,    // latents of a minibatch (learner/distillation)
  kStudentNoise = 33,   // on a student's actions
  kCarryOn = 34,        // whether a body goes on where its clip has ended
  kMirror = 35,         // which sequences of a minibatch are mirrored
};

// Identity of one draw: equal keys give equal numbers, on every machine, in
// every thread, in any order.
struct RandomKey {
  uint64_t seed = 0;
  uint64_t environment = 0;  // or parameter index, iteration ...
  uint64_t episode = 0;
  uint64_t step = 0;
  RandomPurpose purpose = RandomPurpose::kStart;
};

// Counter-based generator (Philox4x64-10 of Salmon et al., "Parallel random
// numbers: as easy as 1, 2, 3", SC 2011, from Random123): a pure function of
// key and index. Its 128-bit key holds seed and purpose, its 256-bit counter
// environment, episode, step and index, so distinct draws never collide.
// The four functions below read the same stream of a key: give each use a
// purpose, step or environment of its own.
//
// Thread-safety: pure functions. Blocking: never. Errors: none.

// Fills `out` with independent U[0, 1) numbers, 24 random bits each; element i
// depends on (key, i) only.
void FillUniform(const RandomKey& key, absl::Span<float> out);

// Fills `out` with independent N(0, 1) numbers: Box-Muller in double from 53
// random bits each, rounded to float; largest magnitude 8.6. Logarithm, sine
// and cosine are our own arithmetic (error below 1e-12), so the bits do not
// depend on the machine's C library. Element i depends on (key, i) only.
void FillNormal(const RandomKey& key, absl::Span<float> out);

// One U[0, 1) number with 53 random bits.
double Uniform(const RandomKey& key, uint64_t index = 0);

// One integer uniform on [0, bound); bound >= 1. Probabilities are off by less
// than bound / 2^64.
uint64_t UniformInt(const RandomKey& key, uint64_t bound, uint64_t index = 0);

}  // namespace sinew

#endif  // SINEW_COMMON_RANDOM_PHILOX_H_
