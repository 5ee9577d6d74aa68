#include "learner/ppo/minibatches.h"

#include <numeric>
#include <utility>

#include "common/random/philox.h"

namespace sinew::learner {

void ShuffleRows(uint64_t seed, int64_t iteration, int epoch,
                 std::vector<int64_t>& order) {
  std::iota(order.begin(), order.end(), int64_t{0});
  const RandomKey key = {.seed = seed,
                         .environment = static_cast<uint64_t>(iteration),
                         .episode = static_cast<uint64_t>(epoch),
                         .purpose = RandomPurpose::kShuffle};
  for (size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[UniformInt(key, i, i)]);
  }
}

}  // namespace sinew::learner
