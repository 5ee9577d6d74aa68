#include "learner/curriculum/bin_sums.h"

#include <algorithm>
#include <cstddef>

namespace sinew::learner {
namespace {

// Sum of value(bin) by clip.
template <typename Value>
std::vector<double> SumByClip(const v1::CurriculumTable& table, Value value) {
  int clips = table.clips_size();
  for (const auto& bin : table.bins()) clips = std::max(clips, bin.clip() + 1);
  std::vector<double> sums(static_cast<size_t>(clips), 0.0);
  for (const auto& bin : table.bins()) sums[bin.clip()] += value(bin);
  return sums;
}

}  // namespace

double TotalFrames(const v1::CurriculumTable& table) {
  double total = 0;
  for (const auto& bin : table.bins()) total += bin.num_frames();
  return total;
}

std::vector<double> FramesByClip(const v1::CurriculumTable& table) {
  return SumByClip(table, [](const auto& bin) { return bin.num_frames(); });
}

std::vector<double> ShareByClip(const v1::CurriculumTable& table) {
  return SumByClip(table, [](const auto& bin) { return bin.probability(); });
}

double RecentFailureRate(const v1::CurriculumTable::Bin& bin) {
  return (bin.recent_failures() + 1) / (bin.recent_passages() + 2);
}

void Normalise(v1::CurriculumTable& table) {
  double total = 0;
  for (const auto& bin : table.bins()) total += bin.probability();
  for (auto& bin : *table.mutable_bins()) {
    bin.set_probability(bin.probability() / total);
  }
}

}  // namespace sinew::learner
