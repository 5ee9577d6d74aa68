#include "learner/update/graph_normalisers.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace sinew::learner {
namespace {

// Prefixes of the normalisers, in the order of the columns that they see.
std::vector<std::string> Normalisers(const TensorMap& weights) {
  if (weights.contains("normaliser/own/mean")) {
    return {"normaliser/own", "normaliser/goal"};
  }
  return {"normaliser"};
}

}  // namespace

void WriteNormalisers(const Moments& moments, TensorMap& weights) {
  size_t first = 0;
  for (const std::string& prefix : Normalisers(weights)) {
    HostTensor& mean = weights.at(prefix + "/mean");
    const size_t width = mean.num_elements();
    Moments part;
    part.count = moments.count;
    const auto columns = [&](const std::vector<double>& all) {
      const auto begin = all.begin() + static_cast<int64_t>(first);
      return std::vector<double>(begin, begin + static_cast<int64_t>(width));
    };
    part.mean = columns(moments.mean);
    part.squares = columns(moments.squares);
    WriteNormaliser(part, mean.mutable_float32(),
                    weights.at(prefix + "/inverse_std").mutable_float32());
    first += width;
  }
}

void InheritNormalisers(const TensorMap& weights, double count,
                        Moments& moments) {
  if (count == 0) count = kInheritedRows;
  Moments all;
  all.count = count;
  for (const std::string& prefix : Normalisers(weights)) {
    const HostTensor& mean = weights.at(prefix + "/mean");
    Moments part(mean.num_elements());
    InheritMoments(mean.float32(),
                   weights.at(prefix + "/inverse_std").float32(), count, part);
    all.mean.insert(all.mean.end(), part.mean.begin(), part.mean.end());
    all.squares.insert(all.squares.end(), part.squares.begin(),
                       part.squares.end());
  }
  moments = std::move(all);
}

}  // namespace sinew::learner
