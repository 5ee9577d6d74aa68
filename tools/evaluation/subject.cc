#include "tools/evaluation/subject.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "actor/zero_action.h"
#include "common/digest.h"
#include "common/status_macros.h"

namespace sinew::evaluation {
namespace {

// Clip names that an error lists.
constexpr int kListedClips = 12;

absl::StatusOr<std::shared_ptr<const actor::PreparedSnapshot>> Prepare(
    const v1::Snapshot& snapshot, const actor::RolloutAssets& assets) {
  return actor::PreparedSnapshot::Create(
      snapshot, Sha256Hex(SerializeDeterministically(snapshot)), assets);
}

}  // namespace

std::vector<std::string> TrackedBodyNames(const Subject& subject) {
  std::vector<std::string> names;
  for (int column : subject.character().tracked()) {
    names.push_back(subject.library().manifest().bodies(column));
  }
  return names;
}

absl::StatusOr<int> FindClip(const motion::Library& library,
                             const std::string& name) {
  if (name.empty()) return 0;
  const int clip = library.FindClip(name);
  if (clip >= 0) return clip;
  std::vector<std::string> names;
  for (int i = 0; i < std::min(library.num_clips(), kListedClips); ++i) {
    names.push_back(library.clip(i).name());
  }
  if (library.num_clips() > kListedClips) names.push_back("...");
  return absl::NotFoundError(
      absl::StrCat("clip \"", name, "\": expected one of ", library.num_clips(),
                   " clips (", absl::StrJoin(names, ", "), ")"));
}

absl::StatusOr<Subject> MakeZeroActionSubject(
    const v1::Recipe& recipe,
    std::unique_ptr<const character::Character> character,
    std::unique_ptr<const motion::Library> library,
    std::unique_ptr<const world::FallenStates> fallen) {
  Subject subject;
  SINEW_ASSIGN_OR_RETURN(
      subject.assets,
      actor::RolloutAssets::FromParts(recipe, std::move(character),
                                      std::move(library), std::move(fallen)));
  const world::TrackingTask& task = subject.assets->task();
  SINEW_ASSIGN_OR_RETURN(
      const v1::Snapshot zero,
      actor::ZeroActionSnapshot(task.observation_width(), task.action_width()));
  SINEW_ASSIGN_OR_RETURN(subject.zero_action, Prepare(zero, *subject.assets));
  subject.policy = subject.zero_action;
  return subject;
}

absl::StatusOr<Subject> MakeSubject(
    const v1::Recipe& recipe,
    std::unique_ptr<const character::Character> character,
    std::unique_ptr<const motion::Library> library,
    const v1::PolicyGraph& graph, const TensorMap& weights,
    std::unique_ptr<const world::FallenStates> fallen) {
  SINEW_ASSIGN_OR_RETURN(
      Subject subject,
      MakeZeroActionSubject(recipe, std::move(character), std::move(library),
                            std::move(fallen)));
  v1::Snapshot snapshot;
  *snapshot.mutable_graph() = graph;
  snapshot.set_weights(SerializeSafetensors(weights));
  SINEW_ASSIGN_OR_RETURN(subject.policy, Prepare(snapshot, *subject.assets));
  return subject;
}

}  // namespace sinew::evaluation
