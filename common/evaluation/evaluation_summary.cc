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
          .e_acc = Ratio(sums.acceleration, sums.acceleration_frames),
          .velocity_frames = sums.velocity_frames,
          .acceleration_frames = sums.acceleration_frames};
}

std::vector<double> BodyMeans(const Sums& sums) {
  std::vector<double> means = sums.body;
  for (double& mean : means) mean = Ratio(mean, sums.frames);
  return means;
}

using Results = std::vector<const v1::EvaluationResult*>;

// Which start it is of.
std::tuple<int32_t, int32_t, int32_t, int32_t> KeyOf(
    const v1::EvaluationResult& result) {
  return {result.clip(), result.start_frame(), result.steps(),
          result.has_fallen_state() ? result.fallen_state() : -1};
}

// One order for every input order; equal starts have equal results.
Results Sorted(absl::Span<const v1::EvaluationResult> results) {
  Results sorted;
  for (const v1::EvaluationResult& result : results) {
    sorted.push_back(&result);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return KeyOf(*a) < KeyOf(*b); });
  return sorted;
}

ClipSummary SummariseClip(absl::Span<const v1::EvaluationResult* const> results,
                          Sums& sums) {
  ClipSummary summary;
  summary.clip = results.front()->clip();
  summary.first_start_success = results.front()->success();
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

// A set of clips while it grows.
struct Set {
  SetSummary summary;
  Sums sums;

  void Add(bool success,
           absl::Span<const v1::EvaluationResult* const> results) {
    ++summary.clips;
    summary.succeeded_clips += success ? 1 : 0;
    summary.first_start_successes += results.front()->success() ? 1 : 0;
    for (const v1::EvaluationResult* result : results) sums.Add(*result);
  }
  SetSummary Finish() {
    summary.starts = sums.starts;
    summary.succeeded_starts = sums.succeeded;
    summary.frames = sums.frames;
    summary.success_rate = Ratio(summary.succeeded_clips, summary.clips);
    summary.survived_share =
        Ratio(static_cast<double>(sums.frames), sums.asked);
    summary.means = Means(sums);
    summary.body_mm = BodyMeans(sums);
    return summary;
  }
};

}  // namespace

std::vector<bool> LeftOutClips(const v1::MotionLibrary& library) {
  std::vector<bool> left_out;
  for (const v1::ClipInfo& clip : library.clips()) {
    left_out.push_back(clip.left_out());
  }
  return left_out;
}

EvaluationSummary SummariseEvaluation(
    absl::Span<const v1::EvaluationResult> results,
    const std::vector<bool>& left_out) {
  EvaluationSummary summary;
  Set overall, successful;
  Set training, training_successful, others, others_successful;
  const Results sorted = Sorted(results);
  size_t begin = 0;
  while (begin < sorted.size()) {
    size_t end = begin;
    while (end < sorted.size() &&
           sorted[end]->clip() == sorted[begin]->clip()) {
      ++end;
    }
    const auto of_clip =
        absl::MakeConstSpan(sorted).subspan(begin, end - begin);
    Sums sums;
    ClipSummary& clip =
        summary.clips.emplace_back(SummariseClip(of_clip, sums));
    const auto index = static_cast<size_t>(clip.clip);
    clip.left_out = index < left_out.size() && left_out[index];
    overall.Add(clip.success, of_clip);
    (clip.left_out ? others : training).Add(clip.success, of_clip);
    if (clip.success) {
      successful.Add(true, of_clip);
      (clip.left_out ? others_successful : training_successful)
          .Add(true, of_clip);
    }
    begin = end;
  }
  summary.overall = overall.Finish();
  summary.successful = successful.Finish();
  summary.training = training.Finish();
  summary.left_out = others.Finish();
  summary.training_successful = training_successful.Finish();
  summary.left_out_successful = others_successful.Finish();
  return summary;
}

}  // namespace sinew
