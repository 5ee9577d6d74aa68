#ifndef SINEW_TOOLS_TRAINING_RUN_FOLDER_H_
#define SINEW_TOOLS_TRAINING_RUN_FOLDER_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/files.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::tools {

// The folder of a run, locked against a second learner:
//
//   config.textproto   the recipe, defaults filled
//   metrics.jsonl      a row per iteration
//   log.jsonl          what was logged
//   logs/              output of child actors
//   checkpoints/       training states and assets
//   bundle/            the last iteration, exported
//   bundle_best/       the best evaluated iteration, exported
//
// The folder of a procedure has, besides config.textproto and bundle/,
//
//   procedure.json     what was decided and what came of it
//   stages/NN_NAME/    folders of runs
//
// Thread-safety: immutable. Ownership: holds the lock. Blocking: on the disk.
// Errors: FAILED_PRECONDITION: another process trains there (named);
// INVALID_ARGUMENT: it holds states of another recipe (fields, old and new).
class RunFolder {
 public:
  // Opens or makes the folder; refuses the recipe if states that lie in it are
  // of another one. Nothing in it is changed.
  static absl::StatusOr<std::unique_ptr<RunFolder>> Open(
      const std::string& path, const v1::Recipe& recipe);

  // Writes the configuration. `trained_with`: SHA-256 of the recipe
  // (PrintRecipe) of the states, wherever they are kept, that the run goes on
  // from; empty: there are none. INVALID_ARGUMENT, with nothing written, if the
  // recipe is another one.
  absl::Status WriteConfig(const v1::Recipe& recipe,
                           const std::string& trained_with) const;

  // Whether a training state lies in the folder of a run at `path`, or in a
  // stage of a procedure there.
  static bool HasState(const std::string& path);

  // Of the folder at `path`, there or not.
  static std::string CheckpointsOf(const std::string& path) {
    return JoinPath(path, "checkpoints");
  }
  static std::string MetricsOf(const std::string& path) {
    return JoinPath(path, "metrics.jsonl");
  }
  static std::string ProcedureOf(const std::string& path) {
    return JoinPath(path, "procedure.json");
  }

  const std::string& path() const { return path_; }
  std::string config() const { return JoinPath(path_, "config.textproto"); }
  std::string procedure() const { return ProcedureOf(path_); }
  std::string metrics() const { return MetricsOf(path_); }
  std::string log() const { return JoinPath(path_, "log.jsonl"); }
  std::string actor_logs() const { return JoinPath(path_, "logs"); }
  std::string checkpoints() const { return CheckpointsOf(path_); }
  std::string bundle() const { return JoinPath(path_, "bundle"); }
  std::string best_bundle() const { return JoinPath(path_, "bundle_best"); }

 private:
  RunFolder(std::string path, std::unique_ptr<DirectoryLock> lock)
      : path_(std::move(path)), lock_(std::move(lock)) {}
  absl::Status CheckSameRecipe(const v1::Recipe& recipe) const;

  const std::string path_;
  const std::unique_ptr<DirectoryLock> lock_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_FOLDER_H_
