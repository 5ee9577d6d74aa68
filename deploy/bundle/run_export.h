#ifndef SINEW_DEPLOY_BUNDLE_RUN_EXPORT_H_
#define SINEW_DEPLOY_BUNDLE_RUN_EXPORT_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "sim/motion/library.h"

namespace sinew::bundle {

// A run directory becomes a bundle. What it needs for that, so that neither the
// motion library nor the character's files have to be there any more:
//
//   RUN/config.textproto         the recipe, as PrintRecipe writes it
//   RUN/inputs/character/        character::CharacterFiles
//   RUN/inputs/inputs.textproto  v1::RunInputs; written last
//
// When a run starts:  SaveRunInputs(run, character, library);
// at its end:         ExportRun(run, {.snapshot = ...}, run + "/bundle");
//
// Thread-safety: one caller per run directory. Blocking: on the disk. Errors:
// name file and field, expected and found.

// Writes RUN/inputs/ anew; `character` as in Character::Load; `sources`: the
// bundles that the run begins with or learns from; `assets_sha256` as the run's
// states have it.
absl::Status SaveRunInputs(const std::string& run, const std::string& character,
                           const motion::Library& library,
                           absl::Span<const v1::RunInputs::Source> sources = {},
                           const std::string& assets_sha256 = "");

// What SaveRunInputs has written. NOT_FOUND, INVALID_ARGUMENT.
absl::StatusOr<v1::RunInputs> ReadRunInputs(const std::string& run);

// A bundle as a source: "primitive", "teacher" or "init", with the clips, their
// uses and the licences of its own provenance. Pure.
v1::RunInputs::Source MakeSource(absl::string_view role,
                                 const std::string& manifest_sha256,
                                 const v1::BundleProvenance& provenance);
v1::RunInputs::Source MakeSource(absl::string_view role,
                                 const v1::BundleManifest& manifest);

// What a run came to.
struct RunResult {
  // A serialised v1::Snapshot.
  absl::string_view snapshot = {};
  int64_t iterations = 0;
  int64_t samples = 0;
  double train_seconds = 0;
  // BuildIdentity() of the program that trained.
  std::string build = {};
  std::optional<v1::BundleMetrics> metrics = std::nullopt;
};

// Writes the bundle (WriteBundle) of a run's snapshot. NOT_FOUND: the run has
// no config.textproto or inputs/. INVALID_ARGUMENT, DATA_LOSS: what the run
// holds does not fit itself or the snapshot.
absl::Status ExportRun(const std::string& run, const RunResult& result,
                       const std::string& directory);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_RUN_EXPORT_H_
