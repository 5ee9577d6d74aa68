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
    Parts parts = Divide(table);
    if (parts.share < 1) rule_->Weigh(parts.named);
    if (parts.share > 0) rule_->Weigh(parts.others);
    int next_named = 0;
    int next_other = 0;
    for (auto& bin : *table.mutable_bins()) {
      if (IsNamed(table, bin.clip())) {
        bin.set_probability((1 - parts.share) *
                            parts.named.bins(next_named++).probability());
      } else {
        bin.set_probability(parts.share *
                            parts.others.bins(next_other++).probability());
      }
    }
  }

  double FloorShare(const v1::CurriculumTable& table) const override {
    const Parts parts = Divide(table);
    double floor = 0;
    if (parts.share < 1) {
      floor += (1 - parts.share) * rule_->FloorShare(parts.named);
    }
    if (parts.share > 0) floor += parts.share * rule_->FloorShare(parts.others);
    return floor;
  }

  bool Draws(const v1::CurriculumTable& table, int clip) const override {
    return others_ > 0 || IsNamed(table, clip);
  }

 private:
  // The table with the bins of the named clips alone, with those of the others
  // alone, and the share of these.
  struct Parts {
    v1::CurriculumTable named, others;
    double share = 0;
  };

  bool IsNamed(const v1::CurriculumTable& table, int clip) const {
    return clip < table.clips_size() &&
           names_.contains(table.clips(clip).name());
  }

  Parts Divide(const v1::CurriculumTable& table) const {
    Parts parts;
    parts.named = PartOf(table, [&](int clip) { return IsNamed(table, clip); });
    parts.others =
        PartOf(table, [&](int clip) { return !IsNamed(table, clip); });
    if (others_ > 0 && !parts.others.bins().empty()) {
      parts.share = parts.named.bins().empty() ? 1 : others_;
    }
    return parts;
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
