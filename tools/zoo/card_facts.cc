#include "tools/zoo/card_facts.h"

#include <memory>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/json_fields.h"
#include "common/rpc/credentials.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/procedure/procedure.h"
#include "learner/state/newest_state.h"
#include "sim/motion/library.h"
#include "tools/training/procedure_record.h"
#include "tools/training/run_folder.h"
#include "tools/training/shown_folder.h"
#include "tools/zoo/zoo_entry.h"

namespace sinew::zoo {
namespace {

using Json = nlohmann::json;
using tools::RunFolder;

// A string of an object in an object; empty: there is none.
std::string StringAt(const Json& file, const char* object, const char* key) {
  const auto outer = file.find(object);
  if (outer == file.end()) return "";
  const auto inner = outer->find(key);
  if (inner == outer->end() || !inner->is_string()) return "";
  return inner->get<std::string>();
}

absl::StatusOr<Json> ReadObject(const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  Json file = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!file.is_object()) {
    return UnfitField(path, "file", "a JSON object", "something else");
  }
  return file;
}

// What `sinew eval` wrote of this bundle.
absl::StatusOr<Json> ReadEvaluation(const std::string& path,
                                    const v1::BundleManifest& manifest) {
  SINEW_ASSIGN_OR_RETURN(Json file, ReadObject(path));
  const std::string found = StringAt(file, "bundle", "manifest_sha256");
  if (found != manifest.manifest_sha256()) {
    return UnfitField(path, "bundle.manifest_sha256",
                      manifest.manifest_sha256(), found);
  }
  return file;
}

absl::Status ReadEvaluations(const CardOptions& options, CardFacts* facts) {
  const v1::BundleManifest& manifest = facts->bundle.manifest;
  if (!options.eval.empty()) {
    SINEW_ASSIGN_OR_RETURN(facts->evaluation,
                           ReadEvaluation(options.eval, manifest));
    facts->evaluation_file = options.eval;
    const std::string library =
        StringAt(facts->evaluation, "library", "sha256");
    if (library != facts->library_sha256) {
      return UnfitField(options.eval, "library.sha256", facts->library_sha256,
                        library);
    }
    if (facts->evaluation.contains("fallen")) {
      facts->fallen = facts->evaluation["fallen"];
    }
  }
  if (options.fallen.empty()) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const Json file,
                         ReadEvaluation(options.fallen, manifest));
  if (!file.contains("fallen")) {
    return UnfitField(options.fallen, "fallen",
                      "an object (sinew eval --fallen)", "none");
  }
  facts->fallen = file["fallen"];
  return absl::OkStatus();
}

// What `sinew sample` wrote of this bundle, beside this library.
absl::Status ReadSamples(const std::string& path, CardFacts* facts) {
  SINEW_ASSIGN_OR_RETURN(Json file, ReadObject(path));
  const Json digest = file.value("manifest_sha256", Json());
  const std::string& expected = facts->bundle.manifest.manifest_sha256();
  if (digest != expected) {
    return UnfitField(path, "manifest_sha256", expected, digest.dump());
  }
  const std::string library = StringAt(file, "library", "sha256");
  if (library != facts->library_sha256) {
    return UnfitField(path, "library.sha256", facts->library_sha256, library);
  }
  if (!file.contains("start") || !file["start"].is_string()) {
    return UnfitField(path, "start", "text", "none");
  }
  if (!file.contains("ways") || !file["ways"].is_array()) {
    return UnfitField(path, "ways", "an array", "none");
  }
  for (const Json& way : file["ways"]) {
    if (!way.is_object() || !way.contains("name") || !way["name"].is_string()) {
      return UnfitField(path, "ways.name", "text", "none");
    }
    if (way.contains("transitions") && !way["transitions"].is_object()) {
      return UnfitField(path, "ways.transitions", "an object",
                        "something else");
    }
  }
  facts->samples = std::move(file);
  return absl::OkStatus();
}

RunFacts FactsOfManifest(const v1::BundleProvenance& provenance) {
  RunFacts facts;
  facts.recipe = provenance.recipe();
  facts.seed = provenance.seed();
  facts.samples = provenance.samples();
  facts.train_seconds = provenance.train_seconds();
  return facts;
}

// Of the last whole row.
absl::Status AddRow(const std::string& folder, RunFacts* facts) {
  const std::string path = RunFolder::MetricsOf(folder);
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  const std::vector<absl::string_view> lines = absl::StrSplit(text, '\n');
  for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
    const Json row = Json::parse(line->begin(), line->end(), nullptr,
                                 /*allow_exceptions=*/false);
    if (!row.is_object()) continue;
    const auto cores = row.find("cores");
    if (cores != row.end() && cores->is_number_integer()) {
      facts->cores = cores->get<int64_t>();
    }
    return absl::OkStatus();
  }
  return UnfitField(path, "rows", "at least one", "none");
}

// Where the newest state knows; runs kept without states say nothing.
std::string CpuClassOf(const std::string& folder, const Clock& clock) {
  const std::string where = RunFolder::CheckpointsOf(folder);
  if (!FileExists(where)) return "";
  const auto store = checkpoint::OpenStore(
      where, checkpoint::StoreAccess::kRead, rpc::Security(), clock);
  if (!store.ok()) return "";
  std::vector<std::string> warnings;
  const auto counters = learner::LoadLatestCounters(**store, &warnings);
  return counters.ok() ? counters->cpu_class() : "";
}

absl::StatusOr<v1::Recipe> RecipeOf(const std::string& folder) {
  const std::string config = JoinPath(folder, "config.textproto");
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(config));
  return ParseRecipe(text, config);
}

// Unset: the run is no procedure.
absl::StatusOr<std::optional<tools::ProcedureRecord>> ProcedureOf(
    const std::string& run) {
  const std::string path = RunFolder::ProcedureOf(run);
  if (!FileExists(path)) return std::nullopt;
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  SINEW_ASSIGN_OR_RETURN(tools::ProcedureRecord record,
                         tools::ParseProcedure(text, path));
  return record;
}

// Whether a bundle comes from the run, or from a stage of it: by its recipe.
absl::Status CheckMadeBy(const std::string& run, const v1::Recipe& recipe,
                         const std::optional<tools::ProcedureRecord>& record,
                         const v1::BundleProvenance& bundle) {
  const auto made_by = [&](const v1::Recipe& one) {
    return Sha256Hex(PrintRecipe(one)) == bundle.recipe_sha256();
  };
  if (made_by(recipe)) return absl::OkStatus();
  if (record) {
    for (const tools::ProcedureRecord::Entry& stage : record->stages) {
      const auto one = RecipeOf(JoinPath(run, stage.directory));
      if (one.ok() && made_by(*one)) return absl::OkStatus();
    }
  }
  return UnfitField(
      run, "recipe",
      absl::StrCat("the bundle's, ", bundle.recipe(), " of SHA-256 ",
                   bundle.recipe_sha256()),
      absl::StrCat(recipe.name(), " of ", Sha256Hex(PrintRecipe(recipe))));
}

// Sums and sentences of a procedure.
void AddProcedure(const tools::ProcedureRecord& record, RunFacts* facts) {
  const learner::Cost cost = learner::CostOf(record.Finished());
  facts->samples = cost.samples;
  facts->train_seconds = cost.train_seconds;
  for (const tools::ProcedureRecord::Entry& entry : record.stages) {
    facts->decisions.push_back(entry.decision.reason);
  }
  if (record.end) facts->decisions.push_back(record.end->reason);
}

absl::Status AddRun(const std::string& run, const v1::BundleProvenance& bundle,
                    const Clock& clock, RunFacts* facts) {
  SINEW_ASSIGN_OR_RETURN(const v1::Recipe recipe, RecipeOf(run));
  SINEW_ASSIGN_OR_RETURN(const auto record, ProcedureOf(run));
  SINEW_RETURN_IF_ERROR(CheckMadeBy(run, recipe, record, bundle));
  facts->recipe = recipe.name();
  facts->seed = recipe.seed();
  const std::string folder = tools::FolderWithRows(run);
  SINEW_RETURN_IF_ERROR(AddRow(folder, facts));
  facts->cpu_class = CpuClassOf(folder, clock);
  if (record) AddProcedure(*record, facts);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CardFacts> ReadCardFacts(const CardOptions& options,
                                        const Clock& clock) {
  CardFacts facts;
  SINEW_ASSIGN_OR_RETURN(facts.bundle, bundle::ReadBundle(options.bundle));
  SINEW_ASSIGN_OR_RETURN(facts.bundle_bytes, CheckBundleBytes(options.bundle));
  SINEW_ASSIGN_OR_RETURN(const auto library,
                         motion::Library::Load(options.motions));
  facts.library = library->manifest();
  facts.library_sha256 = library->digest();
  SINEW_RETURN_IF_ERROR(ReadEvaluations(options, &facts));
  if (!options.samples.empty()) {
    SINEW_RETURN_IF_ERROR(ReadSamples(options.samples, &facts));
  }
  facts.run = FactsOfManifest(facts.bundle.manifest.provenance());
  if (!options.run.empty()) {
    SINEW_RETURN_IF_ERROR(AddRun(
        options.run, facts.bundle.manifest.provenance(), clock, &facts.run));
  }
  facts.command = options.command;
  facts.machine = options.machine;
  return facts;
}

}  // namespace sinew::zoo
