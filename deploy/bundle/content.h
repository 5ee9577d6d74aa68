#ifndef SINEW_DEPLOY_BUNDLE_CONTENT_H_
#define SINEW_DEPLOY_BUNDLE_CONTENT_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "sim/character/character.h"

namespace sinew::bundle {

// What a bundle says about a run.
struct ContentInputs {
  // Defaults filled.
  v1::Recipe recipe;
  // Compiled with the recipe's physics; borrowed for the call.
  const character::Character* character = nullptr;
  // character::CharacterFiles of it.
  std::map<std::string, std::string> character_files;
  // Manifest and Library::digest() of the library that was trained on.
  v1::MotionLibrary library;
  std::string library_sha256;
  // Of RunInputs: bundles that the run was made from.
  std::vector<v1::RunInputs::Source> sources;
  // A serialised v1::Snapshot: its graphs but "teacher", and their weights,
  // become the bundle's.
  absl::string_view snapshot;
  // Of the training that led to the snapshot.
  int64_t iterations = 0;
  int64_t samples = 0;
  double train_seconds = 0;
  std::string build;
};

// Everything that WriteBundle needs, in the order of the character: joints with
// gains and limits, tracked bodies, layout and widths of the observation (and
// of the latent, where the snapshot has graphs for one), action law, physics,
// provenance. The sources' clips and licences stand behind the library's own,
// each once; of a source that names no licence, the licence is "unknown". What
// each clip was to training: ClipUsesOfRun (clip_uses.h). Metrics are left
// unset. Deterministic.
//
// Thread-safety: pure. Blocking: never. Errors: INVALID_ARGUMENT naming what
// does not fit: a snapshot that is none, its weights, a block of the recipe.
absl::StatusOr<BundleContent> MakeContent(const ContentInputs& inputs);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_CONTENT_H_
