#include "learner/curriculum/curriculum_summary.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <tuple>

#include "learner/curriculum/bin_sums.h"

namespace sinew::learner {
namespace {

double NegPLogP(double p) { return p > 0 ? -p * std::log(p) : 0; }

int Tenth(int count) { return (count + 9) / 10; }

int ClipsWithBins(const v1::CurriculumTable& table) {
  const std::vector<double> frames = FramesByClip(table);
  return static_cast<int>(std::count_if(frames.begin(), frames.end(),
                                        [](double n) { return n > 0; }));
}

void SummariseEntropy(const v1::CurriculumTable& table,
                      CurriculumSummary& summary) {
  const double frames = TotalFrames(table);
  double uniform = 0;
  for (const auto& bin : table.bins()) {
    summary.entropy += NegPLogP(bin.probability());
    uniform += NegPLogP(bin.num_frames() / frames);
    summary.failure_rate += RecentFailureRate(bin) * bin.num_frames() / frames;
  }
  if (uniform > 0) summary.entropy_share = summary.entropy / uniform;
}

void SummariseShares(const v1::CurriculumTable& table,
                     CurriculumSummary& summary) {
  std::vector<double> shares = ShareByClip(table);
  std::sort(shares.begin(), shares.end(), std::greater<>());
  double sum = 0;
  for (const double share : shares) {
    if (sum >= 0.5) break;
    sum += share;
    ++summary.clips_of_half;
  }
  if (!shares.empty()) summary.largest_clip_share = shares.front();
  const std::vector<int> hardest = HardestBins(table, Tenth(summary.bins));
  for (const int b : hardest) {
    const v1::CurriculumTable::Bin& bin = table.bins(b);
    summary.hardest_share += bin.probability();
    summary.hardest_failure_rate +=
        RecentFailureRate(bin) / static_cast<double>(hardest.size());
  }
}

void SummariseEvaluations(const v1::CurriculumTable& table,
                          CurriculumSummary& summary) {
  std::vector<double> successes;
  for (const auto& clip : table.clips()) {
    if (clip.left_out() || clip.evaluations() == 0) continue;
    successes.push_back(clip.succeeded_share());
    summary.hard_clips += clip.failed_latest() ? 1 : 0;
  }
  summary.evaluated_clips = static_cast<int>(successes.size());
  if (successes.empty()) return;
  std::sort(successes.begin(), successes.end());
  const int worst = Tenth(summary.evaluated_clips);
  summary.worst_success =
      std::accumulate(successes.begin(), successes.begin() + worst, 0.0) /
      worst;
}

// The first `count` of 0 .. size - 1 in rising order of key(index).
template <typename Key>
std::vector<int> First(int size, int count, Key key) {
  std::vector<int> order(static_cast<size_t>(size));
  std::iota(order.begin(), order.end(), 0);
  const int kept = std::clamp(count, 0, size);
  std::partial_sort(order.begin(), order.begin() + kept, order.end(),
                    [&key](int a, int b) {
                      return std::tuple_cat(key(a), std::tuple(a)) <
                             std::tuple_cat(key(b), std::tuple(b));
                    });
  order.resize(static_cast<size_t>(kept));
  return order;
}

}  // namespace

CurriculumSummary Summarise(const v1::CurriculumTable& table,
                            const StartRule& rule) {
  CurriculumSummary summary;
  summary.clips = ClipsWithBins(table);
  for (const auto& clip : table.clips()) {
    summary.left_out_clips += clip.left_out() ? 1 : 0;
  }
  const v1::CurriculumTable drawn = DrawnPart(table, rule);
  summary.drawn_clips = ClipsWithBins(drawn);
  summary.bins = drawn.bins_size();
  if (summary.bins == 0) return summary;
  summary.floor_share = rule.FloorShare(table);
  SummariseEntropy(drawn, summary);
  SummariseShares(drawn, summary);
  SummariseEvaluations(table, summary);
  return summary;
}

std::vector<ClipStatistics> StatisticsByClip(const v1::CurriculumTable& table) {
  const std::vector<double> frames = FramesByClip(table);
  std::vector<ClipStatistics> clips(frames.size());
  for (const auto& bin : table.bins()) {
    ClipStatistics& clip = clips[bin.clip()];
    ++clip.bins;
    clip.visits += bin.visits();
    clip.failures += bin.failures();
    clip.failure_rate +=
        RecentFailureRate(bin) * bin.num_frames() / frames[bin.clip()];
    clip.probability += bin.probability();
    clip.last_seen = std::max(clip.last_seen, bin.last_seen());
  }
  return clips;
}

std::vector<int> HardestBins(const v1::CurriculumTable& table, int count) {
  return First(table.bins_size(), count, [&table](int b) {
    return std::tuple(-RecentFailureRate(table.bins(b)));
  });
}

std::vector<int> HardestClips(const v1::CurriculumTable& table, int count) {
  const std::vector<ClipStatistics> clips = StatisticsByClip(table);
  const auto failed_share = [&table](int c) {
    if (c >= table.clips_size() || table.clips(c).evaluations() == 0) return 0.;
    return 1 - table.clips(c).succeeded_share();
  };
  std::vector<int> order =
      First(static_cast<int>(clips.size()), static_cast<int>(clips.size()),
            [&](int c) {
              return std::tuple(-failed_share(c), -clips[c].failure_rate);
            });
  std::erase_if(order, [&clips](int c) { return clips[c].bins == 0; });
  order.resize(std::min(order.size(), static_cast<size_t>(std::max(0, count))));
  return order;
}

}  // namespace sinew::learner
