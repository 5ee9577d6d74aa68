#include "learner/curriculum/curriculum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/status_macros.h"
#include "learner/curriculum/only_clips_check.h"

namespace sinew::learner {
namespace {

// Weight of the newest episode in a bin's running mean error.
constexpr double kErrorRate = 0.1;
// Recent counts below this are as good as none.
constexpr double kForgotten = 1e-9;

// More frames than any clip has, so that sums of a few do not overflow.
constexpr double kMaxFrames = 1 << 30;

int64_t Frames(double seconds, double frames_per_second) {
  return std::llround(std::min(seconds * frames_per_second, kMaxFrames));
}

void CopyStatistics(const v1::CurriculumTable::Bin& from,
                    v1::CurriculumTable::Bin& to) {
  to.set_visits(from.visits());
  to.set_failures(from.failures());
  to.set_mean_body_distance(from.mean_body_distance());
  to.set_last_seen(from.last_seen());
  to.set_recent_passages(from.recent_passages());
  to.set_recent_failures(from.recent_failures());
}

// First bin of each clip that has any.
std::map<int, int> FirstBins(const v1::CurriculumTable& table) {
  std::map<int, int> first;
  for (int b = 0; b < table.bins_size(); ++b) {
    first.try_emplace(table.bins(b).clip(), b);
  }
  return first;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Curriculum>> Curriculum::Create(
    const v1::Start& start, const v1::MotionLibrary& library,
    absl::Span<const std::string> clip_sha256) {
  if (library.clips_size() == 0) {
    return absl::InvalidArgumentError(
        "motion library: expected at least one clip, found none");
  }
  const size_t clips = static_cast<size_t>(library.clips_size());
  if (!clip_sha256.empty() && clip_sha256.size() != clips) {
    return absl::InvalidArgumentError(
        absl::StrCat("curriculum: expected a digest for each of ", clips,
                     " clips, found ", clip_sha256.size()));
  }
  auto result = std::unique_ptr<Curriculum>(new Curriculum());
  const double rate = library.frames_per_second();
  const v1::AdaptiveBins adaptive = WithDefaults(start.adaptive());
  result->table_.set_bin_frames(static_cast<int32_t>(
      std::max<int64_t>(1, Frames(start.bin_seconds(), rate))));
  result->pre_failure_frames_ = Frames(adaptive.pre_failure_seconds(), rate);
  result->half_life_passages_ = adaptive.half_life_passages();
  for (int clip = 0; clip < library.clips_size(); ++clip) {
    SINEW_RETURN_IF_ERROR(result->AddClip(
        library.clips(clip), clip_sha256.empty() ? "" : clip_sha256[clip]));
  }
  if (result->table_.bins_size() == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("motion library: expected at least one clip that is not "
                     "left out of training, found none in ",
                     clips));
  }
  SINEW_RETURN_IF_ERROR(CheckOnlyClips(start, library));
  result->rule_ = MakeStartRule(start);
  result->MarkDrawn();
  result->Reweigh();
  return result;
}

absl::Status Curriculum::AddClip(const v1::ClipInfo& info,
                                 const std::string& sha256) {
  const int index = table_.clips_size();
  const int64_t frames = info.num_frames() - (info.loops() ? 0 : 1);
  if (frames < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("clip ", info.name(), ": expected >= 2 frames, found ",
                     info.num_frames()));
  }
  v1::CurriculumTable::Clip& clip = *table_.add_clips();
  clip.set_name(info.name());
  clip.set_sha256(sha256);
  clip.set_left_out(info.left_out());
  clip.set_last_evaluated(-1);
  ClipBins& bins = clips_.emplace_back();
  bins.first = table_.bins_size();
  bins.frames = frames;
  bins.loops = info.loops();
  if (info.left_out()) return absl::OkStatus();
  const int64_t width = table_.bin_frames();
  for (int64_t first = 0; first < frames; first += width) {
    v1::CurriculumTable::Bin& bin = *table_.add_bins();
    bin.set_clip(index);
    bin.set_first_frame(static_cast<int32_t>(first));
    bin.set_num_frames(static_cast<int32_t>(std::min(width, frames - first)));
    bin.set_last_seen(-1);
    ++bins.count;
  }
  return absl::OkStatus();
}

void Curriculum::MarkDrawn() {
  drawn_bins_ = 0;
  for (size_t c = 0; c < clips_.size(); ++c) {
    ClipBins& bins = clips_[c];
    bins.drawn = bins.count > 0 && rule_->Draws(table_, static_cast<int>(c));
    if (bins.drawn) drawn_bins_ += bins.count;
  }
}

v1::CurriculumTable::Bin& Curriculum::BinAt(const ClipBins& clip,
                                            int64_t frame) {
  const int64_t within =
      clip.loops ? frame % clip.frames : std::min(frame, clip.frames - 1);
  return *table_.mutable_bins(clip.first +
                              static_cast<int>(within / table_.bin_frames()));
}

int64_t Curriculum::LastOfPassage(const ClipBins& clip,
                                  const v1::CurriculumTable::Bin& bin,
                                  int64_t frame, int64_t end) const {
  const int64_t bin_end = int64_t{bin.first_frame()} + bin.num_frames();
  // The last bin holds all that follows.
  if (!clip.loops && bin_end >= clip.frames) return end;
  const int64_t within = clip.loops ? frame % clip.frames : frame;
  return std::min(end, frame + bin_end - within - 1);
}

void Curriculum::RunThrough(const ClipBins& clip, int64_t start, int64_t steps,
                            bool failed) {
  const int64_t end = start + steps;
  const int64_t cause = failed ? end - pre_failure_frames_ : end + 1;
  for (int64_t frame = start; frame <= end;) {
    v1::CurriculumTable::Bin& bin = BinAt(clip, frame);
    const int64_t last = LastOfPassage(clip, bin, frame, end);
    ++passages_;
    bin.set_recent_passages(bin.recent_passages() + 1);
    if (failed && last == end) {
      bin.set_recent_failures(bin.recent_failures() + 1);
    } else if (last >= cause) {
      const int64_t led_there = last - std::max(frame, cause) + 1;
      bin.set_recent_failures(bin.recent_failures() +
                              static_cast<double>(led_there) /
                                  static_cast<double>(last - frame + 1));
    }
    frame = last + 1;
  }
}

void Curriculum::Record(const v1::EpisodeEnd& episode, int64_t iteration) {
  if (episode.start_kind() != v1::START_KIND_REFERENCE) return;
  const ClipBins& clip = clips_[episode.clip()];
  if (clip.count == 0) return;
  v1::CurriculumTable::Bin& begun = BinAt(clip, episode.start_frame());
  const double old_mean = begun.mean_body_distance();
  begun.set_mean_body_distance(
      begun.visits() == 0
          ? episode.mean_body_distance()
          : old_mean + kErrorRate * (episode.mean_body_distance() - old_mean));
  begun.set_visits(begun.visits() + 1);
  begun.set_last_seen(iteration);
  const bool failed = episode.reason() == v1::EpisodeEnd::REASON_TERMINATED;
  if (failed) {
    v1::CurriculumTable::Bin& bin =
        BinAt(clip, int64_t{episode.start_frame()} + episode.steps());
    bin.set_failures(bin.failures() + 1);
  }
  const bool diverged = episode.reason() == v1::EpisodeEnd::REASON_DIVERGED;
  RunThrough(clip, episode.start_frame(), episode.steps(), failed || diverged);
}

void Curriculum::RecordEvaluation(
    absl::Span<const v1::EvaluationResult> results, int64_t iteration) {
  std::vector<v1::EvaluationResult> standing;
  for (const v1::EvaluationResult& result : results) {
    if (!result.has_fallen_state()) standing.push_back(result);
  }
  for (const ClipSummary& summary : SummariseEvaluation(standing).clips) {
    v1::CurriculumTable::Clip& clip = *table_.mutable_clips(summary.clip);
    clip.set_evaluations(clip.evaluations() + 1);
    clip.set_failed_evaluations(clip.failed_evaluations() +
                                (summary.success ? 0 : 1));
    clip.set_failed_latest(!summary.success);
    clip.set_succeeded_share(static_cast<double>(summary.succeeded_starts) /
                             summary.starts);
    clip.set_mean_error_mm(summary.means.e_g_mpjpe_mm);
    clip.set_last_evaluated(iteration);
  }
}

void Curriculum::Forget() {
  if (passages_ == 0) return;
  const double keep = std::exp2(-static_cast<double>(passages_) /
                                (drawn_bins_ * half_life_passages_));
  passages_ = 0;
  for (auto& bin : *table_.mutable_bins()) {
    if (!clips_[bin.clip()].drawn) continue;
    const double passages = bin.recent_passages() * keep;
    const double failures = bin.recent_failures() * keep;
    bin.set_recent_passages(passages < kForgotten ? 0 : passages);
    bin.set_recent_failures(failures < kForgotten ? 0 : failures);
  }
}

void Curriculum::Reweigh() {
  Forget();
  rule_->Weigh(table_);
}

absl::Status Curriculum::Restore(const v1::CurriculumTable& table) {
  if (table.bins_size() != table_.bins_size() ||
      table.bin_frames() != table_.bin_frames()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "curriculum of the training state: expected ", table_.bins_size(),
        " bins of ", table_.bin_frames(), " frames, found ", table.bins_size(),
        " of ", table.bin_frames(), "; the library has changed"));
  }
  // A state from before clips were remembered has none.
  if (table.clips_size() != 0 && table.clips_size() != table_.clips_size()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "curriculum of the training state: expected ", table_.clips_size(),
        " clips, found ", table.clips_size(), "; the library has changed"));
  }
  for (int c = 0; c < table.clips_size(); ++c) {
    if (table.clips(c).name() == table_.clips(c).name()) continue;
    return absl::FailedPreconditionError(
        absl::StrCat("curriculum of the training state: clip ", c,
                     ": expected ", table_.clips(c).name(), ", found ",
                     table.clips(c).name(), "; the library has changed"));
  }
  const v1::CurriculumTable fresh = std::move(table_);
  table_ = table;
  if (table.clips_size() == 0) *table_.mutable_clips() = fresh.clips();
  return absl::OkStatus();
}

void Curriculum::AdoptBins(const ClipBins& clip,
                           const v1::CurriculumTable& table, int first) {
  const int end = first + clip.count;
  if (clip.count == 0 || table.bin_frames() != table_.bin_frames() ||
      end > table.bins_size() ||
      table.bins(end - 1).clip() != table.bins(first).clip()) {
    return;
  }
  for (int b = 0; b < clip.count; ++b) {
    CopyStatistics(table.bins(first + b), *table_.mutable_bins(clip.first + b));
  }
}

int Curriculum::Adopt(const v1::CurriculumTable& table) {
  std::map<std::string_view, int> by_name;
  for (int c = 0; c < table.clips_size(); ++c) {
    by_name[table.clips(c).name()] = c;
  }
  const std::map<int, int> first_bins = FirstBins(table);
  int adopted = 0;
  for (int c = 0; c < table_.clips_size(); ++c) {
    v1::CurriculumTable::Clip& clip = *table_.mutable_clips(c);
    const auto found = by_name.find(clip.name());
    if (found == by_name.end() || clip.sha256().empty() ||
        table.clips(found->second).sha256() != clip.sha256()) {
      continue;
    }
    ++adopted;
    const bool left_out = clip.left_out();
    clip = table.clips(found->second);
    clip.set_left_out(left_out);
    // A clip that was left out had no bins.
    const auto first = first_bins.find(found->second);
    if (first != first_bins.end()) AdoptBins(clips_[c], table, first->second);
  }
  Reweigh();
  return adopted;
}

}  // namespace sinew::learner
