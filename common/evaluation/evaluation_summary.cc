#include "common/evaluation/evaluation_summary.h"

#include <algorithm>
#include <tuple>

namespace sinew {
namespace {

// Sums of results.
struct Sums {
  int32_t starts = 0, succeeded = 0;
  int64_t frames = 0, asked = 0, velocity_frames = 0, acceleration_frames = 0;
  double g_mpjpe = 0, mpjpe = 0, velocity = 0, acceleration = 0;
  std::vector<double> body;

  void Add(const v1::EvaluationResult& result) {
    ++starts;
    succeeded += result.success() ? 1 : 0;
    frames += result.frames();
    asked += result.steps();
    velocity_frames += result.velocity_frames();
    acceleration_frames += result.acceleration_frames();
    g_mpjpe += result.sum_g_mpjpe_mm();
    mpjpe += result.sum_mpjpe_mm();
    velocity += result.sum_velocity();
    acceleration += result.sum_acceleration();
    const size_t bodies = static_cast<size_t>(result.sum_body_mm_size());
    if (body.size() < bodies) body.resize(bodies, 0.0);
    for (size_t b = 0; b < bodies; ++b) {
      body[b] += result.sum_body_mm(static_cast<int>(b));
    }
  }
};

double Ratio(double sum, int64_t count) {
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

MetricMeans Means(const Sums& sums) {
  return {.e_g_mpjpe_mm = Ratio(sums.g_mpjpe, sums.frames),
          .e_mpjpe_mm = Ratio(sums.mpjpe, sums.frames),
          .e_vel = Ratio(sums.velocity, sums.velocity_frames),
          .e_acc = Ratio(sums.acceleration, sums.acceleration_frames)};
}

std::vector<double> BodyMeans(const Sums& sums) {
  std::vector<double> means = sums.body;
  for (double& mean : means) mean = Ratio(mean, sums.frames);
  return means;
}

using Results = std::vector<const v1::EvaluationResult*>;

// One order for every input order; equal starts have equal results.
Results Sorted(absl::Span<const v1::EvaluationResult> results) {
  Results sorted;
  for (const v1::EvaluationResult& result : results) {
    sorted.push_back(&result);
  }
  std::sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) {
    return std::tuple(a->clip(), a->start_frame(), a->steps()) <
           std::tuple(b->clip(), b->start_frame(), b->steps());
  });
  return sorted;
}

ClipSummary SummariseClip(absl::Span<const v1::EvaluationResult* const> results,
                          Sums& sums) {
  ClipSummary summary;
  summary.clip = results.front()->clip();
  for (const v1::EvaluationResult* result : results) {
    sums.Add(*result);
    const int32_t failed = result->failed_at_frame();
    if (!result->success() &&
        (summary.failed_at_frame < 0 || failed < summary.failed_at_frame)) {
      summary.failed_at_frame = failed;
    }
  }
  summary.starts = sums.starts;
  summary.succeeded_starts = sums.succeeded;
  summary.success = sums.succeeded == sums.starts;
  summary.frames = sums.frames;
  summary.means = Means(sums);
  summary.body_mm = BodyMeans(sums);
  return summary;
}

void Finish(const Sums& sums, SetSummary* set) {
  set->starts = sums.starts;
  set->succeeded_starts = sums.succeeded;
  set->frames = sums.frames;
  set->success_rate = Ratio(set->succeeded_clips, set->clips);
  set->survived_share = Ratio(static_cast<double>(sums.frames), sums.asked);
  set->means = Means(sums);
  set->body_mm = BodyMeans(sums);
}

}  // namespace

EvaluationSummary SummariseEvaluation(
    absl::Span<const v1::EvaluationResult> results) {
  EvaluationSummary summary;
  Sums overall, successful;
  const Results sorted = Sorted(results);
  size_t begin = 0;
  while (begin < sorted.size()) {
    size_t end = begin;
    while (end < sorted.size() &&
           sorted[end]->clip() == sorted[begin]->clip()) {
      ++end;
    }
    Sums sums;
    summary.clips.push_back(SummariseClip(
        absl::MakeConstSpan(sorted).subspan(begin, end - begin), sums));
    const bool success = summary.clips.back().success;
    ++summary.overall.clips;
    summary.overall.succeeded_clips += success ? 1 : 0;
    if (success) {
      ++summary.successful.clips;
      ++summary.successful.succeeded_clips;
    }
    for (size_t i = begin; i < end; ++i) {
      overall.Add(*sorted[i]);
      if (success) successful.Add(*sorted[i]);
    }
    begin = end;
  }
  Finish(overall, &summary.overall);
  Finish(successful, &summary.successful);
  return summary;
}

}  // namespace sinew
