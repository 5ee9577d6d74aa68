#include "tools/report/run_record.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/json_fields.h"

namespace sinew::report {
namespace {

Json Parse(absl::string_view text) {
  return Json::parse(text.begin(), text.end(), nullptr,
                     /*allow_exceptions=*/false);
}

// A JSON object from a file; null with a note if there is none.
Json ReadObject(const std::string& path, const char* otherwise,
                std::vector<std::string>* notes) {
  if (!FileExists(path)) {
    notes->push_back(otherwise);
    return nullptr;
  }
  const auto text = ReadFile(path);
  if (!text.ok()) {
    notes->push_back(std::string(text.status().message()));
    return nullptr;
  }
  Json object = Parse(*text);
  if (object.is_object()) return object;
  notes->push_back(
      absl::StrCat(path, ": expected a JSON object, found something else"));
  return nullptr;
}

// manifest_sha256 of a bundle's folder; empty: there is none.
std::string BundleDigest(const std::string& bundle) {
  const auto text = ReadFile(JoinPath(bundle, "manifest.json"));
  return text.ok() ? TextAt(Parse(*text), {"manifest_sha256"}) : "";
}

// Sets the bundle that the report is about: that of the evaluation. An
// evaluation of a bundle that the run no longer has goes, as what the run
// became since is not what it measured.
void ChooseBundle(RunRecord* run) {
  run->bundle = JoinPath(run->directory, "bundle");
  if (!run->evaluation.is_object()) return;
  const std::string evaluated =
      TextAt(run->evaluation, {"bundle", "manifest_sha256"});
  bool any = false;
  for (const char* name : {"bundle", "bundle_best"}) {
    const std::string bundle = JoinPath(run->directory, name);
    const std::string digest = BundleDigest(bundle);
    any = any || !digest.empty();
    if (digest.empty() || digest != evaluated) continue;
    run->bundle = bundle;
    return;
  }
  if (!any) return;  // nothing to say that it is of another
  run->evaluation = nullptr;
  run->notes.push_back(absl::StrCat(
      JoinPath(run->directory, "eval.json"),
      ": bundle.manifest_sha256: expected that of the run's bundle or "
      "bundle_best, found ",
      evaluated.empty() ? "none" : evaluated,
      ": left out. Figures of the result are those of evaluations in "
      "training; `sinew eval` makes new ones."));
}

void ReadRows(const std::string& path, RunRecord* run) {
  const auto text = ReadFile(path);
  if (!text.ok()) {
    run->notes.push_back(std::string(text.status().message()));
    return;
  }
  int line_number = 0, bad = 0, first_bad = 0;
  for (absl::string_view line : absl::StrSplit(*text, '\n')) {
    ++line_number;
    if (line.empty()) continue;
    Json row = Parse(line);
    if (row.is_object()) {
      run->rows.push_back(std::move(row));
    } else if (bad++ == 0) {
      first_bad = line_number;
    }
  }
  if (bad > 0) {
    run->notes.push_back(absl::StrCat(
        path, ": ", bad, " lines are no JSON objects (first: line ", first_bad,
        "); left out"));
  }
}

}  // namespace

absl::StatusOr<RunRecord> ReadRun(const std::string& directory) {
  const std::string config = JoinPath(directory, "config.textproto");
  const std::string metrics = JoinPath(directory, "metrics.jsonl");
  if (!FileExists(config) && !FileExists(metrics)) {
    return absl::NotFoundError(
        absl::StrCat(directory,
                     ": expected a run directory with config.textproto and "
                     "metrics.jsonl, found neither"));
  }
  RunRecord run;
  run.directory = directory;
  if (auto text = ReadFile(config); text.ok()) {
    run.config = *std::move(text);
  } else {
    run.notes.push_back(std::string(text.status().message()));
  }
  ReadRows(metrics, &run);
  run.evaluation = ReadObject(JoinPath(directory, "eval.json"),
                              "The run has no eval.json: figures of the "
                              "result are those of evaluations in training.",
                              &run.notes);
  run.evaluated_motions = TextAt(run.evaluation, {"library", "path"});
  ChooseBundle(&run);
  run.manifest = ReadObject(
      JoinPath(run.bundle, "manifest.json"),
      "The run has no bundle, so there is nothing to show in motion.",
      &run.notes);
  return run;
}

v1::Recipe RecipeOf(const RunRecord& run) {
  const auto recipe = ParseRecipe(run.config, "config.textproto");
  return recipe.ok() ? *recipe : v1::Recipe();
}

}  // namespace sinew::report
