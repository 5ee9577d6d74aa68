#ifndef SINEW_TOOLS_REPORT_RUN_RECORD_H_
#define SINEW_TOOLS_REPORT_RUN_RECORD_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::report {

using Json = nlohmann::ordered_json;

// What a run left on disk, as it lies there.
struct RunRecord {
  std::string directory;
  std::string config;      // config.textproto
  std::vector<Json> rows;  // metrics.jsonl; objects, in order
  // eval.json; null: none of a bundle that the run has. Where it has no bundle
  // at all, eval.json as it is.
  Json evaluation;
  std::string evaluated_motions;  // library that eval.json names; may be empty
  // The bundle that was evaluated, else the run's last one.
  std::string bundle;  // its folder; there may be nothing
  Json manifest;       // its manifest.json; null: no bundle
  // Sentences about what is absent or could not be read.
  std::vector<std::string> notes;
};

// Reads a run directory. Tolerant: whatever is absent or damaged becomes a
// note, as reports are also written about runs that failed. Blocks on the
// disk. NOT_FOUND if the directory holds neither config.textproto nor
// metrics.jsonl.
absl::StatusOr<RunRecord> ReadRun(const std::string& directory);

// The recipe that `config` is; an empty one if it is none. Pure.
v1::Recipe RecipeOf(const RunRecord& run);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_RUN_RECORD_H_
