#include "learner/curriculum/only_clips_rule.h"

#include <utility>

namespace sinew::learner {
namespace {

class OnlyClipsRule final : public StartRule {
 public:
  OnlyClipsRule(std::set<std::string> names, std::unique_ptr<StartRule> rule)
      : names_(std::move(names)), rule_(std::move(rule)) {}

  void Weigh(v1::CurriculumTable& table) const override {
    v1::CurriculumTable part = DrawnPart(table, *this);
    rule_->Weigh(part);
    int next = 0;
    for (auto& bin : *table.mutable_bins()) {
      bin.set_probability(
          Draws(table, bin.clip()) ? part.bins(next++).probability() : 0);
    }
  }

  double FloorShare(const v1::CurriculumTable& table) const override {
    return rule_->FloorShare(DrawnPart(table, *this));
  }

  bool Draws(const v1::CurriculumTable& table, int clip) const override {
    return clip < table.clips_size() &&
           names_.contains(table.clips(clip).name());
  }

 private:
  const std::set<std::string> names_;
  const std::unique_ptr<StartRule> rule_;
};

}  // namespace

std::unique_ptr<StartRule> MakeOnlyClipsRule(std::set<std::string> names,
                                             std::unique_ptr<StartRule> rule) {
  return std::make_unique<OnlyClipsRule>(std::move(names), std::move(rule));
}

}  // namespace sinew::learner
