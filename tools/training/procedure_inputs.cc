#include "tools/training/procedure_inputs.h"

#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "sim/import/quality_gate.h"
#include "sim/motion/library.h"
#include "sim/world/start.h"
#include "tools/evaluation/rejected_clips.h"

namespace sinew::tools {
namespace {

// Of ProcedureRecord::assets.
constexpr char kInitRole[] = "init";

// Of all clips; more should be somebody's decision.
constexpr double kMostCleanedShare = 0.1;

}  // namespace

ProcedureInputs MakeProcedureInputs(const v1::Recipe& recipe,
                                    const TaskSetup& setup,
                                    const std::string& init_sha256) {
  const v1::Start& start = recipe.task().start();
  const v1::MotionLibrary& library = setup.library->manifest();
  ProcedureInputs inputs;
  ProcedureRecord& record = inputs.record;
  for (const v1::ClipInfo& clip : library.clips()) {
    inputs.clips.push_back(clip.name());
    if (world::IsDrawn(start, clip)) inputs.trained_on.push_back(clip.name());
    if (clip.left_out()) ++record.left_out_clips;
  }
  record.recipe_sha256 = Sha256Hex(PrintRecipe(recipe));
  for (const char* role : {"character", "model"}) {
    record.assets[role] = Sha256Hex(*setup.assets.at(role));
  }
  record.assets["library"] = setup.library->digest();
  if (!init_sha256.empty()) record.assets[kInitRole] = init_sha256;
  record.library_clips = library.clips_size();
  record.trained_on_clips = static_cast<int>(inputs.trained_on.size());
  return inputs;
}

absl::Status CheckClean(const v1::MotionLibrary& library) {
  for (const v1::ClipInfo& clip : library.clips()) {
    const import::Verdict verdict = import::JudgeQuality(clip.quality());
    std::string reason;
    if (verdict.status == import::ClipStatus::kRejected) {
      reason = verdict.reason;
    } else {
      reason = import::TooShort(clip, static_cast<double>(clip.num_frames()) /
                                          library.frames_per_second());
    }
    if (reason.empty()) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "motion library clip \"", clip.name(), "\": ", reason,
        "; import the library again, which leaves such clips out"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<std::map<std::string, std::string>>> CleanedAway(
    const std::string& motions, int clips) {
  SINEW_ASSIGN_OR_RETURN(const auto rejected,
                         evaluation::RejectedClips(motions, clips));
  if (!rejected) return std::nullopt;
  std::map<std::string, std::string> cleaned;
  for (const evaluation::RejectedClip& clip : *rejected) {
    cleaned[clip.name] = clip.reason;
  }
  const int all = clips + static_cast<int>(rejected->size());
  if (static_cast<double>(rejected->size()) > kMostCleanedShare * all) {
    LogWarning(
        "the import turned many clips away, see its report",
        {{"library", motions}, {"rejected", rejected->size()}, {"of", all}});
  }
  return cleaned;
}

absl::Status CheckSameInputs(const ProcedureRecord& found,
                             const ProcedureRecord& expected,
                             const std::string& run) {
  std::vector<std::string> changed;
  if (found.recipe_sha256 != expected.recipe_sha256) {
    changed.push_back("recipe");
  }
  // What it began with no longer matters once its first stage has ended.
  const bool first_ended = !found.stages.empty() && found.stages[0].finished;
  auto before = found.assets;
  auto now = expected.assets;
  if (first_ended) {
    before.erase(kInitRole);
    now.erase(kInitRole);
  }
  for (const auto& [role, sha256] : before) now.emplace(role, "");
  for (const auto& [role, sha256] : now) {
    if (before[role] != sha256) changed.push_back(role);
  }
  if (changed.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      run,
      ": expected the recipe, character, motion library and --init that the "
      "procedure was started with, found others (changed: ",
      absl::StrJoin(changed, ", "), "); give the same, or another --run"));
}

std::string StageDirectory(const learner::Stage& stage, int index) {
  return absl::StrFormat("stages/%02d_%s", index, learner::StageName(stage));
}

absl::Status CheckFollows(const ProcedureRecord& record,
                          const v1::Procedure& procedure,
                          const std::vector<std::string>& trained_on,
                          const std::string& source) {
  const std::vector<learner::FinishedStage> finished = record.Finished();
  for (size_t i = 0; i < record.stages.size(); ++i) {
    const ProcedureRecord::Entry& known = record.stages[i];
    std::string expected = "none, since the one before has not ended";
    if (i <= finished.size()) {
      const learner::Decision decision = learner::NextStage(
          procedure, trained_on, absl::MakeConstSpan(finished).first(i));
      expected = decision.next
                     ? StageDirectory(*decision.next, static_cast<int>(i))
                     : "none, since the procedure is over";
      if (decision.next == known.decision.next && known.directory == expected) {
        continue;
      }
    }
    return absl::DataLossError(
        absl::StrCat(source, ": expected stage ", i, " to be ", expected,
                     ", which follows from those before it, found ",
                     known.directory, " or another set of clips"));
  }
  return absl::OkStatus();
}

absl::Status CheckSameLibrary(const ProcedureRecord& record,
                              const std::string& motions) {
  SINEW_ASSIGN_OR_RETURN(const auto library, motion::Library::Load(motions));
  if (record.assets.at("library") == library->digest()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      motions,
      ": expected the motion library that the procedure was started with, "
      "found another one (changed: library); put it back and give the same "
      "command again"));
}

}  // namespace sinew::tools
