#include "tools/training/kept_fallen_states.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/files.h"
#include "deploy/checkpoint/open_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::tools {
namespace {

constexpr char kFallen[] = "fallen";
// What fallen states are made of: character, physics, count and seed.
constexpr const char* kSources[] = {"character", "model", "recipe"};

// Digests of an artifact's files by role.
std::map<std::string, std::string> Digests(const v1::Artifact& artifact) {
  std::map<std::string, std::string> digests;
  for (const v1::Artifact::File& file : artifact.files()) {
    digests[file.path()] = file.sha256();
  }
  return digests;
}

// The first source that is another one; empty: none.
absl::string_view FirstDifference(
    const std::map<std::string, std::string>& kept,
    const std::map<std::string, std::string>& wanted) {
  for (const auto& [role, sha256] : wanted) {
    const auto found = kept.find(role);
    if (found == kept.end() || found->second != sha256) return role;
  }
  return "";
}

std::string Note(absl::string_view artifact, absl::string_view why) {
  return absl::StrCat("fallen states are made anew, not taken from ", artifact,
                      ": ", why);
}

}  // namespace

Blob FindFallenStates(checkpoint::ArtifactStore& store,
                      const std::map<std::string, std::string>& assets,
                      std::vector<std::string>* notes) {
  std::map<std::string, std::string> wanted;
  for (const char* role : kSources) wanted[role] = Sha256Hex(assets.at(role));
  const auto list = store.ListArtifacts("assets");
  if (!list.ok()) {
    notes->push_back(Note("the run's assets", list.status().message()));
    return nullptr;
  }
  std::vector<std::string> found;
  for (const std::string& damaged : list->damaged()) {
    found.push_back(absl::StrCat(
        "fallen states are made anew, passed over a damaged record: ",
        damaged));
  }
  for (const v1::Artifact& artifact : list->artifacts()) {
    const std::map<std::string, std::string> kept = Digests(artifact);
    const auto fallen = kept.find(kFallen);
    if (fallen == kept.end()) continue;
    const absl::string_view other = FirstDifference(kept, wanted);
    if (!other.empty()) {
      found.push_back(
          Note(artifact.id(), absl::StrCat("they are of another ", other)));
      continue;
    }
    const absl::StatusOr<Blob> bytes = store.GetBlob(fallen->second);
    if (bytes.ok()) return *bytes;
    found.push_back(Note(artifact.id(), bytes.status().message()));
  }
  notes->insert(notes->end(), found.begin(), found.end());
  return nullptr;
}

Blob FindFallenStatesAt(const FallenStatesPlace& place, const Clock& clock,
                        const StopToken& stop,
                        const std::map<std::string, std::string>& assets,
                        std::vector<std::string>* notes) {
  if (place.address.empty() && !FileExists(place.folder)) return nullptr;
  const auto store = checkpoint::OpenStore(
      place.address.empty() ? place.folder : place.address,
      checkpoint::StoreAccess::kRead, place.security, clock, stop);
  if (store.ok()) return FindFallenStates(**store, assets, notes);
  notes->push_back(
      absl::StrCat("fallen states are made anew: ", store.status().message()));
  return nullptr;
}

}  // namespace sinew::tools
