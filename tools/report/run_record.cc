#include "tools/report/run_record.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/files.h"

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

// Folder of the bundle that the report is about.
std::string BundleOf(const RunRecord& run) {
  if (run.evaluation.is_object()) {
    const Json bundle = run.evaluation.value("bundle", Json());
    const Json path =
        bundle.is_object() ? bundle.value("path", Json()) : Json();
    if (path.is_string() &&
        FileExists(JoinPath(path.get<std::string>(), "manifest.json"))) {
      return path.get<std::string>();
    }
  }
  return JoinPath(run.directory, "bundle");
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
  run.bundle = BundleOf(run);
  run.manifest = ReadObject(
      JoinPath(run.bundle, "manifest.json"),
      "The run has no bundle, so there is nothing to show in motion.",
      &run.notes);
  return run;
}

}  // namespace sinew::report
