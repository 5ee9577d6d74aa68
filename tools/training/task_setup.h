#ifndef SINEW_TOOLS_TRAINING_TASK_SETUP_H_
#define SINEW_TOOLS_TRAINING_TASK_SETUP_H_

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"
#include "common/segment/mirror.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "sim/motion/library.h"
#include "sim/world/observation.h"

namespace sinew::tools {

// What a run is about, compiled: what actors fetch, and what the learner must
// know of it.
struct TaskSetup {
  std::shared_ptr<const motion::Library> library;
  std::vector<std::string> clip_sha256;  // sim/motion/clip_digest.h
  // The character's name, digest, and joints in the order of actions.
  std::string character, character_sha256;
  std::vector<std::string> joints;
  std::shared_ptr<const world::ObservationBuilder> observation;
  int observation_width = 0;
  // Columns that the observation begins with and that are about the body alone.
  int self_observation_width = 0;
  int action_width = 0;
  // Radians per unit of action (sim/world/action.h), [A].
  std::vector<double> action_scales;
  v1::SegmentLayout layout;
  std::string layout_sha256;
  v1::StateLimits limits;
  // Of the task, if the recipe learns from mirror images.
  std::optional<SegmentMirror> mirror;
  // The serialised TaskAssets, its SHA-256, and the assets that it names by
  // role.
  Blob list;
  std::string assets_sha256;
  std::map<std::string, Blob> assets;
};

// Fallen states that are kept from before of a task with these other assets
// (bytes by role: character, model, recipe ...), or null.
using KeptFallenStates =
    std::function<Blob(const std::map<std::string, std::string>& others)>;

// Loads a character (name or file) and a motion library (folder), compiles the
// character for the recipe (defaults filled, valid), and builds the task from
// the assets' bytes just as an actor will. Fallen states, where the recipe has
// them, are what `kept` has (if they are of this character and as many as asked
// for), else made anew. Some clip must be one that is trained on, and a
// student's law must reach its labels (student_reach.h). Blocks on the disk.
// NOT_FOUND, INVALID_ARGUMENT naming file and field.
absl::StatusOr<TaskSetup> SetUpTask(const v1::Recipe& recipe,
                                    const std::string& character,
                                    const std::string& motions,
                                    const KeptFallenStates& kept = nullptr);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_TASK_SETUP_H_
