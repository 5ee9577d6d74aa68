#include "learner/curriculum/start_rule.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "common/config/recipe.h"
#include "learner/curriculum/adaptive_bins.h"
#include "learner/curriculum/bin_sums.h"
#include "learner/curriculum/only_clips_rule.h"

namespace sinew::learner {
namespace {

// Weight of a clip that was won, where one that was not has 1: its floor is all
// that it gets, unless all are won or caps leave something over.
constexpr double kWonWeight = 1e-6;

class UniformRule final : public StartRule {
 public:
  void Weigh(v1::CurriculumTable& table) const override {
    const double total = TotalFrames(table);
    for (auto& bin : *table.mutable_bins()) {
      bin.set_probability(bin.num_frames() / total);
    }
  }
  double FloorShare(const v1::CurriculumTable&) const override { return 1; }
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
  double FloorShare(const v1::CurriculumTable&) const override {
    return uniform_share_;
  }

 private:
  static double Weight(const v1::CurriculumTable::Bin& bin) {
    return bin.num_frames() * (static_cast<double>(bin.failures()) + 1) /
           (static_cast<double>(bin.visits()) + 2);
  }

  const double uniform_share_;
};

// Weighs clips by what their evaluations found, if any failed the latest.
class PhcRule : public StartRule {
 public:
  void Weigh(v1::CurriculumTable& table) const final {
    const std::vector<double> frames = FramesByClip(table);
    bool any_failed = false;
    for (int c = 0; c < table.clips_size(); ++c) {
      any_failed |= frames[c] > 0 && table.clips(c).failed_latest();
    }
    std::vector<double> weights(frames.size());
    double total = 0;
    for (size_t c = 0; c < weights.size(); ++c) {
      if (frames[c] == 0) continue;
      weights[c] = any_failed ? Weight(table.clips(static_cast<int>(c))) : 1;
      total += weights[c];
    }
    for (auto& bin : *table.mutable_bins()) {
      const int clip = bin.clip();
      bin.set_probability(weights[clip] / total * bin.num_frames() /
                          frames[clip]);
    }
    Normalise(table);
  }
  double FloorShare(const v1::CurriculumTable&) const final { return 0; }

 private:
  virtual double Weight(const v1::CurriculumTable::Clip& clip) const = 0;
};

class PhcSoftRule final : public PhcRule {
  double Weight(const v1::CurriculumTable::Clip& clip) const override {
    return static_cast<double>(clip.failed_evaluations());
  }
};

class PhcHardRule final : public PhcRule {
  double Weight(const v1::CurriculumTable::Clip& clip) const override {
    return clip.failed_latest() ? 1 : 0;
  }
};

double RecentWeight(const v1::CurriculumTable::Bin& bin) {
  return bin.num_frames() * RecentFailureRate(bin);
}

// A clip's weight by its latest evaluation. `frames` and `bin_weights` by clip,
// sums over its bins.
std::vector<double> EvaluationWeights(const v1::CurriculumTable& table,
                                      const std::vector<double>& frames,
                                      const std::vector<double>& bin_weights) {
  std::vector<double> weights(frames.size(), 0.0);
  for (size_t c = 0; c < weights.size(); ++c) {
    if (frames[c] == 0) continue;
    const int clip = static_cast<int>(c);
    const bool won = clip < table.clips_size() &&
                     table.clips(clip).evaluations() > 0 &&
                     !table.clips(clip).failed_latest();
    weights[c] = won ? kWonWeight * bin_weights[c] / frames[c] : 1;
  }
  return weights;
}

class AdaptiveBinsRule final : public StartRule {
 public:
  explicit AdaptiveBinsRule(const v1::AdaptiveBins& adaptive)
      : adaptive_(adaptive) {}

  void Weigh(v1::CurriculumTable& table) const override {
    const std::vector<double> frames = FramesByClip(table);
    const std::vector<ClipLimits> limits = Limits(frames);
    std::vector<double> weights(frames.size(), 0.0);
    for (const auto& bin : table.bins()) {
      weights[bin.clip()] += RecentWeight(bin);
    }
    const bool by_evaluations =
        adaptive_.clip_weight() == v1::AdaptiveBins::CLIP_WEIGHT_EVALUATIONS;
    const std::vector<double> extras = ShareAboveFloors(
        limits,
        by_evaluations ? EvaluationWeights(table, frames, weights) : weights);
    for (auto& bin : *table.mutable_bins()) {
      const int clip = bin.clip();
      bin.set_probability(limits[clip].floor_share * bin.num_frames() /
                              frames[clip] +
                          extras[clip] * RecentWeight(bin) / weights[clip]);
    }
    Normalise(table);
  }

  double FloorShare(const v1::CurriculumTable& table) const override {
    double share = 0;
    for (const ClipLimits& clip : Limits(FramesByClip(table))) {
      share += clip.floor_share;
    }
    return share;
  }

 private:
  std::vector<ClipLimits> Limits(const std::vector<double>& frames) const {
    return LimitClips(frames, adaptive_.bin_floor(), adaptive_.clip_floor(),
                      adaptive_.clip_cap());
  }

  const v1::AdaptiveBins adaptive_;
};

std::unique_ptr<StartRule> MakeRuleOfAllClips(const v1::Start& start) {
  switch (start.rule()) {
    case v1::Start::RULE_BINS:
      return MakeFailureRateRule(start.uniform_share());
    case v1::Start::RULE_PHC_SOFT:
      return MakePhcSoftRule();
    case v1::Start::RULE_PHC_HARD:
      return MakePhcHardRule();
    case v1::Start::RULE_ADAPTIVE_BINS:
      return MakeAdaptiveBinsRule(WithDefaults(start.adaptive()));
    default:
      return MakeUniformRule();
  }
}

}  // namespace

bool StartRule::Draws(const v1::CurriculumTable&, int) const { return true; }

v1::CurriculumTable PartOf(const v1::CurriculumTable& table,
                           absl::FunctionRef<bool(int clip)> keeps) {
  v1::CurriculumTable part;
  part.set_bin_frames(table.bin_frames());
  *part.mutable_clips() = table.clips();
  for (const auto& bin : table.bins()) {
    if (keeps(bin.clip())) *part.add_bins() = bin;
  }
  return part;
}

v1::CurriculumTable DrawnPart(const v1::CurriculumTable& table,
                              const StartRule& rule) {
  return PartOf(table, [&](int clip) { return rule.Draws(table, clip); });
}

std::unique_ptr<StartRule> MakeUniformRule() {
  return std::make_unique<UniformRule>();
}

std::unique_ptr<StartRule> MakeFailureRateRule(double uniform_share) {
  return std::make_unique<FailureRateRule>(uniform_share);
}

std::unique_ptr<StartRule> MakePhcSoftRule() {
  return std::make_unique<PhcSoftRule>();
}

std::unique_ptr<StartRule> MakePhcHardRule() {
  return std::make_unique<PhcHardRule>();
}

std::unique_ptr<StartRule> MakeAdaptiveBinsRule(
    const v1::AdaptiveBins& adaptive) {
  return std::make_unique<AdaptiveBinsRule>(adaptive);
}

std::unique_ptr<StartRule> MakeStartRule(const v1::Start& start) {
  std::unique_ptr<StartRule> rule = MakeRuleOfAllClips(start);
  if (start.only_clips().empty()) return rule;
  return MakeOnlyClipsRule(
      {start.only_clips().begin(), start.only_clips().end()},
      start.other_clips_share(), std::move(rule));
}

}  // namespace sinew::learner
