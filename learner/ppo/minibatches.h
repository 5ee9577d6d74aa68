#ifndef SINEW_LEARNER_PPO_MINIBATCHES_H_
#define SINEW_LEARNER_PPO_MINIBATCHES_H_

#include <cstdint>
#include <vector>

namespace sinew::learner {

// Writes a permutation of 0 ... order.size() - 1, uniform and a pure function
// of (seed, iteration, epoch, size): Fisher-Yates with counter-based numbers.
// Thread-safe, allocates nothing.
void ShuffleRows(uint64_t seed, int64_t iteration, int epoch,
                 std::vector<int64_t>& order);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_MINIBATCHES_H_
