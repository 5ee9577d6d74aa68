#include "learner/procedure/procedure.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace sinew::learner {
namespace {

using ClipSet = absl::flat_hash_set<std::string>;

// Names in a sentence; the evidence has all.
constexpr size_t kNamesShown = 20;

constexpr std::array<std::pair<StageKind, const char*>, 6> kKindNames = {{
    {StageKind::kFull, "full"},
    {StageKind::kHard, "hard"},
    {StageKind::kGrown, "grown"},
    {StageKind::kRecovery, "recovery"},
    {StageKind::kComposer, "composer"},
    {StageKind::kSingle, "single"},
}};

bool Tracks(StageKind kind) {
  return kind == StageKind::kFull || kind == StageKind::kHard ||
         kind == StageKind::kGrown;
}

std::string Names(const std::vector<std::string>& names) {
  const size_t shown = std::min(names.size(), kNamesShown);
  std::string text = absl::StrJoin(names.begin(), names.begin() + shown, ", ");
  if (shown < names.size()) {
    absl::StrAppend(&text, " and ", names.size() - shown, " more");
  }
  return text;
}

// The latest stage of each primitive, by its number. The single one is a
// primitive of none that follow.
std::vector<int> LatestStages(absl::Span<const FinishedStage> finished) {
  std::vector<int> latest;
  for (size_t i = 0; i < finished.size(); ++i) {
    const Stage& stage = finished[i].stage;
    if (stage.kind == StageKind::kComposer ||
        stage.kind == StageKind::kSingle) {
      continue;
    }
    latest.resize(std::max<size_t>(latest.size(), stage.primitive + 1));
    latest[stage.primitive] = static_cast<int>(i);
  }
  return latest;
}

// The stages that track come first.
absl::Span<const FinishedStage> TrackingStages(
    absl::Span<const FinishedStage> finished) {
  const auto end =
      std::find_if(finished.begin(), finished.end(),
                   [](const auto& f) { return !Tracks(f.stage.kind); });
  return finished.first(std::distance(finished.begin(), end));
}

std::vector<std::string> HardSet(const std::vector<std::string>& clips,
                                 absl::Span<const FinishedStage> tracking) {
  std::vector<std::string> hard = clips;
  for (const int i : LatestStages(tracking)) {
    const ClipSet failed(tracking[i].failed.begin(), tracking[i].failed.end());
    std::erase_if(hard,
                  [&](const auto& name) { return !failed.contains(name); });
  }
  return hard;
}

Evidence Weigh(const std::vector<std::string>& clips,
               absl::Span<const FinishedStage> tracking) {
  Evidence evidence;
  evidence.clips = static_cast<int>(clips.size());
  if (tracking.empty()) return evidence;
  evidence.hard = HardSet(clips, tracking);
  const FinishedStage& last = tracking.back();
  if (!IsOnHardSet(last.stage.kind)) return evidence;
  const ClipSet failed(last.failed.begin(), last.failed.end());
  const ClipSet before(last.stage.clips.begin(), last.stage.clips.end());
  evidence.hard_before = static_cast<int>(last.stage.clips.size());
  evidence.hard_won = static_cast<int>(
      std::count_if(last.stage.clips.begin(), last.stage.clips.end(),
                    [&](const auto& name) { return !failed.contains(name); }));
  evidence.forgotten = static_cast<int>(
      std::count_if(evidence.hard.begin(), evidence.hard.end(),
                    [&](const auto& name) { return !before.contains(name); }));
  return evidence;
}

std::string Ending(const FinishedStage& last) {
  return absl::StrFormat("%s ended %s after %d samples", StageName(last.stage),
                         last.plateau ? "at its plateau" : "with its budget",
                         last.samples);
}

// How the latest stage that tracks ended, and what is left.
std::string Account(const FinishedStage& last, const Evidence& evidence) {
  std::string text = Ending(last);
  if (evidence.hard_before > 0) {
    absl::StrAppendFormat(&text, " and won %d of its %d hard clips",
                          evidence.hard_won, evidence.hard_before);
  }
  absl::StrAppendFormat(&text, "; no primitive wins %d of %d clips",
                        evidence.hard.size(), evidence.clips);
  if (!evidence.hard.empty()) {
    absl::StrAppend(&text, " (", Names(evidence.hard), ")");
  }
  if (evidence.forgotten > 0) {
    absl::StrAppendFormat(&text, ", %d of which were won before",
                          evidence.forgotten);
  }
  return text;
}

Stage OnHardSet(StageKind kind, int primitive, size_t finished,
                const Evidence& evidence) {
  return {.kind = kind,
          .primitive = primitive,
          .from = static_cast<int>(finished) - 1,
          .clips = evidence.hard,
          .primitives = {}};
}

// The next stage that tracks, or none; `reason` is added to.
std::optional<Stage> NextTracking(const v1::Procedure& procedure,
                                  absl::Span<const FinishedStage> finished,
                                  const Evidence& evidence,
                                  std::string& reason) {
  const Stage& last = finished.back().stage;
  const int hard = static_cast<int>(evidence.hard.size());
  if (hard <= procedure.negligible_clips()) {
    absl::StrAppendFormat(&reason,
                          ", at most negligible_clips = %d: no more tracking",
                          procedure.negligible_clips());
    return std::nullopt;
  }
  // The margin: 0.1 * 10 must not ask for more than 1.
  if (evidence.hard_won <
      procedure.learnable_share() * evidence.hard_before - 1e-9) {
    absl::StrAppendFormat(
        &reason,
        ": the stage won %.2f of its hard set, less than learnable_share = "
        "%.2f: what is left cannot be learned, no more tracking",
        static_cast<double>(evidence.hard_won) / evidence.hard_before,
        procedure.learnable_share());
    return std::nullopt;
  }
  if (last.kind != StageKind::kHard) {
    absl::StrAppendFormat(&reason, ": primitive_%d goes on on them",
                          last.primitive);
    return OnHardSet(StageKind::kHard, last.primitive, finished.size(),
                     evidence);
  }
  const int primitives = last.primitive + 1;
  if (primitives >= procedure.max_primitives()) {
    absl::StrAppendFormat(&reason,
                          ": max_primitives = %d is reached, no more tracking",
                          procedure.max_primitives());
    return std::nullopt;
  }
  absl::StrAppendFormat(&reason, ": primitive_%d is grown from primitive_%d",
                        primitives, last.primitive);
  return OnHardSet(StageKind::kGrown, primitives, finished.size(), evidence);
}

std::optional<Stage> NextComposer(const v1::Procedure& procedure,
                                  absl::Span<const FinishedStage> finished,
                                  std::string& reason) {
  const std::vector<int> latest = LatestStages(finished);
  if (procedure.composer_samples() == 0) {
    absl::StrAppend(&reason, "; composer_samples = 0: no composer");
    return std::nullopt;
  }
  if (latest.size() < 2) {
    absl::StrAppend(&reason, "; one primitive alone: no composer");
    return std::nullopt;
  }
  absl::StrAppendFormat(&reason, "; next a composer over %d primitives, frozen",
                        latest.size());
  return Stage{.kind = StageKind::kComposer,
               .primitive = static_cast<int>(latest.size()),
               .from = -1,
               .clips = {},
               .primitives = latest};
}

// What comes once no more primitives track: recovery, or else the composer.
std::optional<Stage> AfterTracking(const v1::Procedure& procedure,
                                   absl::Span<const FinishedStage> finished,
                                   std::string& reason) {
  if (procedure.recovery_samples() == 0) {
    absl::StrAppend(&reason, "; recovery_samples = 0: no recovery primitive");
    return NextComposer(procedure, finished, reason);
  }
  const FinishedStage& last = finished.back();
  absl::StrAppendFormat(&reason,
                        "; next a primitive that recovers, from primitive_%d",
                        last.stage.primitive);
  return Stage{.kind = StageKind::kRecovery,
               .primitive = last.stage.primitive + 1,
               .from = static_cast<int>(finished.size()) - 1,
               .clips = {},
               .primitives = {}};
}

// The single primitive, or none; `reason` is added to.
std::optional<Stage> NextSingle(const v1::Procedure& procedure,
                                absl::Span<const FinishedStage> finished,
                                std::string& reason) {
  if (!procedure.compare_single() ||
      finished.back().stage.kind == StageKind::kSingle) {
    return std::nullopt;
  }
  const FinishedStage& first = finished.front();
  const int64_t samples = CostOf(finished).samples - first.samples;
  if (samples == 0) {
    absl::StrAppend(&reason, "; one stage alone: nothing to compare");
    return std::nullopt;
  }
  absl::StrAppendFormat(&reason,
                        "; next %s by itself, on all clips, for as many "
                        "samples as all stages after it took, %d",
                        StageName(first.stage), samples);
  return Stage{.kind = StageKind::kSingle,
               .primitive = first.stage.primitive,
               .from = 0,
               .clips = {},
               .primitives = {},
               .samples = samples};
}

// No stage follows but for comparison, if that.
std::optional<Stage> AfterProcedure(const v1::Procedure& procedure,
                                    absl::Span<const FinishedStage> finished,
                                    std::string& reason) {
  const FinishedStage& result = finished[ResultStage(finished)];
  const std::string policy =
      absl::StrFormat("its policy is that of %s, which fails %d clips",
                      StageName(result.stage), result.failed.size());
  std::string comparison;
  std::optional<Stage> next = NextSingle(procedure, finished, comparison);
  absl::StrAppend(&reason, next ? "; " : "; the procedure is over, ", policy,
                  comparison);
  return next;
}

}  // namespace

bool IsOnHardSet(StageKind kind) {
  return kind == StageKind::kHard || kind == StageKind::kGrown;
}

std::string StageName(const Stage& stage) {
  switch (stage.kind) {
    case StageKind::kFull:
    case StageKind::kGrown:
      return absl::StrCat("primitive_", stage.primitive);
    case StageKind::kHard:
      return absl::StrCat("primitive_", stage.primitive, "_hard");
    default:
      return KindName(stage.kind);
  }
}

std::string KindName(StageKind kind) {
  for (const auto& [known, name] : kKindNames) {
    if (known == kind) return name;
  }
  return "";
}

std::optional<StageKind> KindOfName(const std::string& name) {
  for (const auto& [kind, known] : kKindNames) {
    if (known == name) return kind;
  }
  return std::nullopt;
}

Decision NextStage(const v1::Procedure& procedure,
                   const std::vector<std::string>& clips,
                   absl::Span<const FinishedStage> finished) {
  Decision decision;
  const auto tracking = TrackingStages(finished);
  decision.evidence = Weigh(clips, tracking);
  std::string& reason = decision.reason;
  if (finished.empty()) {
    reason = absl::StrFormat("primitive_0 begins on all %d clips",
                             decision.evidence.clips);
    decision.next = Stage();
    return decision;
  }
  const FinishedStage& last = finished.back();
  if (Tracks(last.stage.kind)) {
    reason = Account(last, decision.evidence);
    decision.next =
        NextTracking(procedure, finished, decision.evidence, reason);
    if (!decision.next) {
      decision.next = AfterTracking(procedure, finished, reason);
    }
  } else {
    reason = absl::StrFormat("%s and fails %d of %d clips", Ending(last),
                             last.failed.size(), decision.evidence.clips);
    if (last.stage.kind == StageKind::kRecovery) {
      decision.next = NextComposer(procedure, finished, reason);
    }
  }
  if (const auto both = Compare(finished)) {
    absl::StrAppendFormat(&reason,
                          ", with %d samples in all beside the procedure's %d",
                          both->single.samples, both->procedure.samples);
  }
  if (!decision.next) {
    decision.next = AfterProcedure(procedure, finished, reason);
  }
  return decision;
}

int ResultStage(absl::Span<const FinishedStage> finished) {
  // Stages that recover come after all that only track.
  const auto recovery = std::find_if(
      finished.begin(), finished.end(),
      [](const auto& one) { return one.stage.kind == StageKind::kRecovery; });
  const size_t first =
      recovery == finished.end() ? 0 : recovery - finished.begin();
  size_t best = first;
  for (size_t i = first; i < finished.size(); ++i) {
    if (finished[i].stage.kind == StageKind::kSingle) continue;
    if (finished[i].failed.size() <= finished[best].failed.size()) best = i;
  }
  return static_cast<int>(best);
}

Cost CostOf(absl::Span<const FinishedStage> finished) {
  Cost cost;
  for (const FinishedStage& stage : finished) {
    if (stage.stage.kind == StageKind::kSingle) continue;
    cost.samples += stage.samples;
    cost.train_seconds += stage.train_seconds;
  }
  return cost;
}

std::optional<Comparison> Compare(absl::Span<const FinishedStage> finished) {
  if (finished.empty() || finished.back().stage.kind != StageKind::kSingle) {
    return std::nullopt;
  }
  const auto side = [&](int stage, int64_t samples) {
    return Comparison::Side{
        .stage = stage,
        .samples = samples,
        .failed = static_cast<int>(finished[stage].failed.size())};
  };
  return Comparison{
      .procedure = side(ResultStage(finished), CostOf(finished).samples),
      .single = side(static_cast<int>(finished.size()) - 1,
                     finished.front().samples + finished.back().samples)};
}

}  // namespace sinew::learner
