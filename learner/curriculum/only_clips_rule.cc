#include "learner/curriculum/only_clips_rule.h"

#include <utility>

namespace sinew::learner {
namespace {

class OnlyClipsRule final : public StartRule {
 public:
  OnlyClipsRule(std::set<std::string> names, double others,
                std::unique_ptr<StartRule> rule)
      : names_(std::move(names)), others_(others), rule_(std::move(rule)) {}

  void Weigh(v1::CurriculumTable& table) const override {
    v1::CurriculumTable named = Part(table, true);
    v1::CurriculumTable others = Part(table, false);
    const double share = OthersShare(named, others);
    if (share < 1) rule_->Weigh(named);
    if (share > 0) rule_->Weigh(others);
    int next_named = 0;
    int next_other = 0;
    for (auto& bin : *table.mutable_bins()) {
      double probability = 0;
      if (Named(table, bin.clip())) {
        probability = (1 - share) * named.bins(next_named++).probability();
      } else if (share > 0) {
        probability = share * others.bins(next_other++).probability();
      }
      bin.set_probability(probability);
    }
  }

  double FloorShare(const v1::CurriculumTable& table) const override {
    const v1::CurriculumTable named = Part(table, true);
    const v1::CurriculumTable others = Part(table, false);
    const double share = OthersShare(named, others);
    double floor = 0;
    if (share < 1) floor += (1 - share) * rule_->FloorShare(named);
    if (share > 0) floor += share * rule_->FloorShare(others);
    return floor;
  }

  bool Draws(const v1::CurriculumTable& table, int clip) const override {
    return others_ > 0 || Named(table, clip);
  }

 private:
  bool Named(const v1::CurriculumTable& table, int clip) const {
    return clip < table.clips_size() &&
           names_.contains(table.clips(clip).name());
  }

  // The table with the bins alone of the named clips, or of the others.
  v1::CurriculumTable Part(const v1::CurriculumTable& table, bool named) const {
    v1::CurriculumTable part;
    part.set_bin_frames(table.bin_frames());
    *part.mutable_clips() = table.clips();
    for (const auto& bin : table.bins()) {
      if (Named(table, bin.clip()) == named) *part.add_bins() = bin;
    }
    return part;
  }

  double OthersShare(const v1::CurriculumTable& named,
                     const v1::CurriculumTable& others) const {
    if (others.bins().empty()) return 0;
    return named.bins().empty() && others_ > 0 ? 1 : others_;
  }

  const std::set<std::string> names_;
  const double others_;
  const std::unique_ptr<StartRule> rule_;
};

}  // namespace

std::unique_ptr<StartRule> MakeOnlyClipsRule(std::set<std::string> names,
                                             double others,
                                             std::unique_ptr<StartRule> rule) {
  return std::make_unique<OnlyClipsRule>(std::move(names), others,
                                         std::move(rule));
}

}  // namespace sinew::learner
