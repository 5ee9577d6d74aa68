#include "tools/training/procedure_record.h"

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr char kPlateau[] = "plateau";
constexpr char kSamples[] = "samples";

Json FinishedJson(const learner::FinishedStage& finished) {
  return {{"end", finished.plateau ? kPlateau : kSamples},
          {"iterations", finished.iterations},
          {"samples", finished.samples},
          {"train_seconds", finished.train_seconds},
          {"best_share", finished.best_share},
          {"stalled", finished.stalled},
          {"failed", finished.failed}};
}

Json RecoveredJson(const ProcedureRecord::Recovered& recovered) {
  return {{"starts", recovered.starts},
          {"within_3_s", recovered.within_3_s},
          {"within_5_s", recovered.within_5_s}};
}

Json EvidenceJson(const learner::Evidence& evidence) {
  return {{"clips", evidence.clips},
          {"hard", evidence.hard},
          {"hard_before", evidence.hard_before},
          {"hard_won", evidence.hard_won},
          {"forgotten", evidence.forgotten}};
}

// The procedure beside the single primitive.
Json ComparisonJson(const ProcedureRecord& record,
                    const learner::Comparison& both) {
  const auto side = [&](const learner::Comparison::Side& one) -> Json {
    return {{"directory", record.stages[one.stage].directory},
            {"samples", one.samples},
            {"clips_failed", one.failed}};
  };
  return {{"procedure", side(both.procedure)}, {"single", side(both.single)}};
}

Json EntryJson(const ProcedureRecord::Entry& entry) {
  const learner::Stage& stage = *entry.decision.next;
  Json json = {{"directory", entry.directory},
               {"kind", learner::KindName(stage.kind)},
               {"primitive", stage.primitive},
               {"from", stage.from},
               {"clips", stage.clips},
               {"primitives", stage.primitives},
               {"evidence", EvidenceJson(entry.decision.evidence)}};
  if (stage.samples > 0) json["samples"] = stage.samples;
  if (entry.finished) json["finished"] = FinishedJson(*entry.finished);
  if (entry.finished && entry.recovered) {
    json["finished"]["recovered"] = RecoveredJson(*entry.recovered);
  }
  return json;
}

// The functions below throw nlohmann's exceptions, which ParseProcedure
// catches.

absl::StatusOr<learner::Stage> StageOf(const Json& json) {
  learner::Stage stage;
  const auto kind = json.at("kind").get<std::string>();
  const auto known = learner::KindOfName(kind);
  if (!known) {
    return absl::DataLossError(absl::StrCat(
        "stages.kind: expected a kind of stage, found \"", kind, "\""));
  }
  stage.kind = *known;
  stage.primitive = json.at("primitive").get<int>();
  if (stage.primitive < 0 || stage.primitive > kMostPrimitives) {
    return absl::DataLossError(absl::StrCat("stages.primitive: expected 0 to ",
                                            kMostPrimitives, ", found ",
                                            stage.primitive));
  }
  stage.from = json.at("from").get<int>();
  stage.clips = json.at("clips").get<std::vector<std::string>>();
  stage.primitives = json.at("primitives").get<std::vector<int>>();
  if (json.contains("samples")) {
    stage.samples = json.at("samples").get<int64_t>();
  }
  return stage;
}

learner::FinishedStage FinishedOf(const Json& json, learner::Stage stage) {
  learner::FinishedStage finished;
  finished.stage = std::move(stage);
  finished.plateau = json.at("end").get<std::string>() == kPlateau;
  finished.iterations = json.at("iterations").get<int64_t>();
  finished.samples = json.at("samples").get<int64_t>();
  finished.train_seconds = json.at("train_seconds").get<double>();
  finished.best_share = json.at("best_share").get<double>();
  finished.stalled = json.at("stalled").get<int>();
  finished.failed = json.at("failed").get<std::vector<std::string>>();
  return finished;
}

ProcedureRecord::Recovered RecoveredOf(const Json& json) {
  return {.starts = json.at("starts").get<int>(),
          .within_3_s = json.at("within_3_s").get<double>(),
          .within_5_s = json.at("within_5_s").get<double>()};
}

learner::Evidence EvidenceOf(const Json& json) {
  return {.clips = json.at("clips").get<int>(),
          .hard = json.at("hard").get<std::vector<std::string>>(),
          .hard_before = json.at("hard_before").get<int>(),
          .hard_won = json.at("hard_won").get<int>(),
          .forgotten = json.at("forgotten").get<int>()};
}

absl::StatusOr<ProcedureRecord::Entry> EntryOf(const Json& json,
                                               std::string reason) {
  ProcedureRecord::Entry entry;
  entry.directory = json.at("directory").get<std::string>();
  SINEW_ASSIGN_OR_RETURN(entry.decision.next, StageOf(json));
  entry.decision.reason = std::move(reason);
  entry.decision.evidence = EvidenceOf(json.at("evidence"));
  if (json.contains("finished")) {
    const Json& finished = json.at("finished");
    entry.finished = FinishedOf(finished, *entry.decision.next);
    if (finished.contains("recovered")) {
      entry.recovered = RecoveredOf(finished.at("recovered"));
    }
  }
  return entry;
}

absl::StatusOr<ProcedureRecord> RecordOf(const Json& json) {
  ProcedureRecord record;
  record.recipe_sha256 = json.at("recipe_sha256").get<std::string>();
  record.assets = json.at("assets").get<std::map<std::string, std::string>>();
  const Json& clips = json.at("clips");
  record.library_clips = clips.at("library").get<int>();
  record.trained_on_clips = clips.at("trained_on").get<int>();
  record.left_out_clips = clips.at("left_out").get<int>();
  if (clips.contains("cleaned_away")) {
    record.cleaned_away =
        clips.at("cleaned_away").get<std::map<std::string, std::string>>();
  }
  const Json& decisions = json.at("decisions");
  const Json& stages = json.at("stages");
  for (size_t i = 0; i < stages.size(); ++i) {
    SINEW_ASSIGN_OR_RETURN(
        ProcedureRecord::Entry entry,
        EntryOf(stages.at(i), decisions.at(i).get<std::string>()));
    record.stages.push_back(std::move(entry));
  }
  if (json.at("over").get<bool>()) {
    record.end.emplace();
    record.end->reason = decisions.at(stages.size()).get<std::string>();
    record.end->evidence = EvidenceOf(json.at("end").at("evidence"));
  }
  return record;
}

}  // namespace

std::vector<learner::FinishedStage> ProcedureRecord::Finished() const {
  std::vector<learner::FinishedStage> finished;
  for (const Entry& entry : stages) {
    if (!entry.finished) break;
    finished.push_back(*entry.finished);
  }
  return finished;
}

bool ProcedureRecord::Decided() const {
  return end.has_value() ||
         (!stages.empty() &&
          stages.back().decision.next->kind == learner::StageKind::kSingle);
}

std::string PrintProcedure(const ProcedureRecord& record) {
  const std::vector<learner::FinishedStage> finished = record.Finished();
  const learner::Cost cost = learner::CostOf(finished);
  Json decisions = Json::array();
  Json stages = Json::array();
  for (const ProcedureRecord::Entry& entry : record.stages) {
    decisions.push_back(entry.decision.reason);
    stages.push_back(EntryJson(entry));
  }
  if (record.end) decisions.push_back(record.end->reason);
  Json json = {{"format_version", kVersion},
               {"recipe_sha256", record.recipe_sha256},
               {"assets", record.assets},
               {"clips",
                {{"library", record.library_clips},
                 {"trained_on", record.trained_on_clips},
                 {"left_out", record.left_out_clips}}},
               {"over", record.end.has_value()},
               {"samples", cost.samples},
               {"train_seconds", cost.train_seconds},
               {"decisions", decisions},
               {"stages", stages}};
  if (record.cleaned_away) {
    json["clips"]["cleaned_away"] = *record.cleaned_away;
  }
  if (record.end) {
    json["end"] = {{"evidence", EvidenceJson(record.end->evidence)}};
  }
  if (const auto both = learner::Compare(finished)) {
    json["comparison"] = ComparisonJson(record, *both);
  }
  return absl::StrCat(json.dump(2), "\n");
}

absl::StatusOr<ProcedureRecord> ParseProcedure(const std::string& text,
                                               const std::string& source) {
  try {
    const Json json = Json::parse(text);
    const int version = json.at("format_version").get<int>();
    if (version != kVersion) {
      return absl::DataLossError(absl::StrCat(source,
                                              ": format_version: expected ",
                                              kVersion, ", found ", version));
    }
    absl::StatusOr<ProcedureRecord> record = RecordOf(json);
    if (record.ok()) return record;
    return absl::DataLossError(
        absl::StrCat(source, ": ", record.status().message()));
  } catch (const Json::exception& error) {
    return absl::DataLossError(absl::StrCat(
        source, ": expected the record of a procedure, found something else (",
        error.what(), ")"));
  }
}

}  // namespace sinew::tools
