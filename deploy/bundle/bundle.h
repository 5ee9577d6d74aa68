#ifndef SINEW_DEPLOY_BUNDLE_BUNDLE_H_
#define SINEW_DEPLOY_BUNDLE_BUNDLE_H_

#include <map>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::bundle {

// A bundle is a folder:
//
//   manifest.json            v1::BundleManifest in proto3 JSON; written last
//   graph.textproto          v1::PolicyGraph: "policy"; with a latent also
//                            "encoder", "prior", "decoder", "sample"
//                            (latent_graphs.h)
//   weights.safetensors      its parameters
//   NAME.onnx                each graph for other runtimes, "policy.onnx" at
//                            least; external data in weights.safetensors
//   character/               character.textproto, its MJCF and meshes
//
// The manifest names every other file with its SHA-256, and its own.
struct Bundle {
  std::string directory;
  v1::BundleManifest manifest;
  v1::PolicyGraph graph;
  TensorMap weights;
  // Compiled with the manifest's physics. Shared, since it is immutable and
  // bundles are copied.
  std::shared_ptr<const character::Character> character;

  // Path of the character's text proto, for character::Character::Load.
  std::string character_file() const {
    return directory + "/character/character.textproto";
  }

  // Path of a graph's ONNX model.
  std::string onnx_file(const std::string& graph_name) const {
    return directory + "/" + graph_name + ".onnx";
  }
};

// What a manifest's provenance calls an origin or a licence that nobody named.
inline constexpr char kUnknown[] = "unknown";

inline std::string OrUnknown(const std::string& text) {
  return text.empty() ? kUnknown : text;
}

// Reads and checks a bundle: version, digest of every file, graph, weights,
// character and manifest that fit each other (joint order, gains, bodies,
// widths), finite numbers. Blocks on the disk. NOT_FOUND (no such folder or
// file), INVALID_ARGUMENT or DATA_LOSS name file, expected and found; nothing
// of a faulty bundle is returned.
absl::StatusOr<Bundle> ReadBundle(const std::string& directory);

// What a bundle is made of.
struct BundleContent {
  // `files`, `graphs`, `format_version` and `manifest_sha256` are filled in by
  // WriteBundle.
  v1::BundleManifest manifest;
  v1::PolicyGraph graph;
  TensorMap weights;
  // Path below character/ -> content.
  std::map<std::string, std::string> character_files;
};

// Writes a bundle into a folder beside `directory` (`directory`.part) and
// renames it into place: a crash leaves the old one or the new one. One writer
// per directory. INVALID_ARGUMENT: content that ReadBundle would refuse;
// FAILED_PRECONDITION: either folder holds something else than a bundle, which
// stays; RESOURCE_EXHAUSTED: disk full, the old one stays.
absl::Status WriteBundle(const BundleContent& content,
                         const std::string& directory);

// The recipe that a bundle was trained with, as far as acting and evaluating
// need it (physics, task, when an evaluation fails), defaults filled: for
// world::TrackingTask::Create. The clips that training drew starts from are
// left out (task.start.only_clips): what is done with the bundle may use all.
v1::Recipe TaskRecipe(const v1::BundleManifest& manifest);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_BUNDLE_H_
