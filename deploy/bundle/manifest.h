#ifndef SINEW_DEPLOY_BUNDLE_MANIFEST_H_
#define SINEW_DEPLOY_BUNDLE_MANIFEST_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/bundle.pb.h"

namespace sinew::bundle {

// Newest manifest version that this build reads, and the one that it writes.
inline constexpr int kBundleFormatVersion = 1;

// Names of the files that every bundle has.
inline constexpr char kManifestFile[] = "manifest.json";
inline constexpr char kGraphFile[] = "graph.textproto";
inline constexpr char kWeightsFile[] = "weights.safetensors";
inline constexpr char kCharacterFolder[] = "character";
inline constexpr char kCharacterFile[] = "character/character.textproto";

// Name of the file with a graph as an ONNX model; every bundle has that of
// "policy".
std::string OnnxFile(absl::string_view graph_name);

// manifest.json to message. INVALID_ARGUMENT or DATA_LOSS naming `source`: no
// manifest; a newer version, by number, before anything else is looked at; a
// text that its own digest does not fit; an unknown field. Pure.
absl::StatusOr<v1::BundleManifest> ParseManifest(absl::string_view json,
                                                 absl::string_view source);

// The other way, signed with its own digest. INTERNAL: protobuf's message.
absl::StatusOr<std::string> PrintManifest(v1::BundleManifest manifest);

// True for paths that may be a file of a bundle: relative, "/" between names,
// no "." or "..", no backslash.
bool IsBundlePath(absl::string_view path);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_MANIFEST_H_
