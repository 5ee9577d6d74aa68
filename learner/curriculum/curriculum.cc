#include "learner/curriculum/curriculum.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sinew::learner {
namespace {

// Weight of the newest episode in a bin's running mean error.
constexpr double kErrorRate = 0.1;

double TotalFrames(const v1::CurriculumTable& table) {
  double total = 0;
  for (const auto& bin : table.bins()) total += bin.num_frames();
  return total;
}

class UniformRule final : public StartRule {
 public:
  void Weigh(v1::CurriculumTable& table) const override {
    const double total = TotalFrames(table);
    for (auto& bin : *table.mutable_bins()) {
      bin.set_probability(bin.num_frames() / total);
    }
  }
};

class FailureRateRule final : public StartRule {
 public:
  explicit FailureRateRule(double uniform_share)
      : uniform_share_(uniform_share) {}

  void Weigh(v1::CurriculumTable& table) const override {
    const double frames = TotalFrames(table);
    double total = 0;
    for (const auto& bin : table.bins()) total += Weight(bin);
    for (auto& bin : *table.mutable_bins()) {
      bin.set_probability((1 - uniform_share_) * Weight(bin) / total +
                          uniform_share_ * bin.num_frames() / frames);
    }
  }

 private:
  static double Weight(const v1::CurriculumTable::Bin& bin) {
    return bin.num_frames() * (static_cast<double>(bin.failures()) + 1) /
           (static_cast<double>(bin.visits()) + 2);
  }

  const double uniform_share_;
};

}  // namespace

std::unique_ptr<StartRule> MakeUniformRule() {
  return std::make_unique<UniformRule>();
}

std::unique_ptr<StartRule> MakeFailureRateRule(double uniform_share) {
  return std::make_unique<FailureRateRule>(uniform_share);
}

absl::StatusOr<std::unique_ptr<Curriculum>> Curriculum::Create(
    const v1::Start& start, const v1::MotionLibrary& library) {
  if (library.clips_size() == 0) {
    return absl::InvalidArgumentError(
        "motion library: expected at least one clip, found none");
  }
  auto result = std::unique_ptr<Curriculum>(new Curriculum());
  const int bin_frames = std::max<int>(
      1, static_cast<int>(
             std::lround(start.bin_seconds() * library.frames_per_second())));
  result->table_.set_bin_frames(bin_frames);
  for (int clip = 0; clip < library.clips_size(); ++clip) {
    const v1::ClipInfo& info = library.clips(clip);
    const int64_t frames = info.num_frames() - (info.loops() ? 0 : 1);
    if (frames < 1) {
      return absl::InvalidArgumentError(
          absl::StrCat("clip ", info.name(), ": expected >= 2 frames, found ",
                       info.num_frames()));
    }
    result->first_bin_.push_back(result->table_.bins_size());
    result->frames_.push_back(frames);
    result->loops_.push_back(info.loops());
    for (int64_t first = 0; first < frames; first += bin_frames) {
      auto& bin = *result->table_.add_bins();
      bin.set_clip(clip);
      bin.set_first_frame(static_cast<int32_t>(first));
      bin.set_num_frames(
          static_cast<int32_t>(std::min<int64_t>(bin_frames, frames - first)));
      bin.set_last_seen(-1);
    }
  }
  result->rule_ = start.rule() == v1::Start::RULE_BINS
                      ? MakeFailureRateRule(start.uniform_share())
                      : MakeUniformRule();
  result->Reweigh();
  return result;
}

v1::CurriculumTable::Bin& Curriculum::BinAt(int clip, int64_t frame) {
  const int64_t frames = frames_[clip];
  const int64_t within =
      loops_[clip] ? frame % frames : std::min(frame, frames - 1);
  return *table_.mutable_bins(first_bin_[clip] +
                              static_cast<int>(within / table_.bin_frames()));
}

void Curriculum::Record(absl::Span<const v1::EpisodeEnd> episodes,
                        int64_t iteration) {
  for (const v1::EpisodeEnd& episode : episodes) {
    auto& begun = BinAt(episode.clip(), episode.start_frame());
    const double old_mean = begun.mean_body_distance();
    begun.set_mean_body_distance(
        begun.visits() == 0
            ? episode.mean_body_distance()
            : old_mean +
                  kErrorRate * (episode.mean_body_distance() - old_mean));
    begun.set_visits(begun.visits() + 1);
    begun.set_last_seen(iteration);
    if (episode.reason() == v1::EpisodeEnd::REASON_TERMINATED) {
      auto& failed = BinAt(episode.clip(),
                           int64_t{episode.start_frame()} + episode.steps());
      failed.set_failures(failed.failures() + 1);
    }
  }
}

void Curriculum::Reweigh() { rule_->Weigh(table_); }

absl::Status Curriculum::Restore(const v1::CurriculumTable& table) {
  if (table.bins_size() != table_.bins_size() ||
      table.bin_frames() != table_.bin_frames()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "curriculum of the training state: expected ", table_.bins_size(),
        " bins of ", table_.bin_frames(), " frames, found ", table.bins_size(),
        " of ", table.bin_frames(), "; the library has changed"));
  }
  table_ = table;
  return absl::OkStatus();
}

}  // namespace sinew::learner
