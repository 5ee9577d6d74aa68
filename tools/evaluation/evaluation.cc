#include "tools/evaluation/evaluation.h"

#include <algorithm>
#include <optional>

#include "common/evaluation/evaluation_starts.h"
#include "common/status_macros.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {
namespace {

// A profile per group, so that threads share nothing and sums do not depend
// on which of them was first.
class GroupProfiles {
 public:
  GroupProfiles(const Subject& subject,
                absl::Span<const v1::EvaluationStart> starts, int clips)
      : starts_(starts), group_of_start_(starts.size()) {
    for (const StartGroup& group : GroupStarts(starts)) {
      std::fill_n(group_of_start_.begin() + static_cast<ptrdiff_t>(group.first),
                  group.size, profiles_.size());
      const int clip = starts[group.first].clip();
      auto& profile = profiles_.emplace_back();
      if (clip < clips) {
        profile.emplace(subject.character(), subject.library(), clip);
      }
      clips_.push_back(clip);
    }
  }

  void Add(size_t start, int frame, const mjData& data) {
    auto& profile = profiles_[group_of_start_[start]];
    if (profile) profile->Add(starts_[start], frame, data);
  }

  std::vector<ErrorProfile> ByClip() && {
    std::vector<ErrorProfile> result;
    for (size_t g = 0; g < profiles_.size(); ++g) {
      if (!profiles_[g]) continue;
      if (g > 0 && clips_[g - 1] == clips_[g]) {
        result.back().Merge(*profiles_[g]);
      } else {
        result.push_back(*std::move(profiles_[g]));
      }
    }
    return result;
  }

 private:
  const absl::Span<const v1::EvaluationStart> starts_;
  std::vector<size_t> group_of_start_;
  std::vector<std::optional<ErrorProfile>> profiles_;  // by group
  std::vector<int> clips_;                             // by group
};

}  // namespace

absl::StatusOr<Evaluation> Evaluate(const Subject& subject,
                                    const EvaluationOptions& options,
                                    const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationStart> starts,
                         MakeEvaluationStarts(subject.library().manifest(),
                                              options.starts, options.seconds));
  GroupProfiles profiles(subject, starts, options.profiles);
  SINEW_ASSIGN_OR_RETURN(
      const std::vector<v1::EvaluationResult> results,
      RunStarts(
          subject.assets, *subject.policy, starts, options.threads, stop,
          [&](size_t start, int frame, const mjData& data,
              absl::Span<const float>) { profiles.Add(start, frame, data); }));
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationResult> zero,
                         RunStarts(subject.assets, *subject.zero_action, starts,
                                   options.threads, stop));
  const std::vector<bool> left_out = LeftOutClips(subject.library().manifest());
  return Evaluation{.policy = SummariseEvaluation(results, left_out),
                    .zero_action = SummariseEvaluation(zero, left_out),
                    .profiles = std::move(profiles).ByClip()};
}

absl::StatusOr<EvaluationSummary> EvaluatePolicy(
    const Subject& subject, const EvaluationOptions& options,
    const StopToken& stop) {
  const v1::MotionLibrary& library = subject.library().manifest();
  SINEW_ASSIGN_OR_RETURN(
      const std::vector<v1::EvaluationStart> starts,
      MakeEvaluationStarts(library, options.starts, options.seconds));
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationResult> results,
                         RunStarts(subject.assets, *subject.policy, starts,
                                   options.threads, stop));
  return SummariseEvaluation(results, LeftOutClips(library));
}

}  // namespace sinew::evaluation
