#include "deploy/bundle/manifest.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "google/protobuf/util/json_util.h"
#include "nlohmann/json.hpp"

namespace sinew::bundle {
namespace {

using google::protobuf::util::JsonParseOptions;
using google::protobuf::util::JsonPrintOptions;

constexpr absl::string_view kDigestKey = "\"manifest_sha256\"";
constexpr size_t kDigestSize = 64;

absl::Status Error(absl::string_view source, absl::string_view field,
                   absl::string_view expected, absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": ", field, ": expected ", expected, ", found ", found));
}

absl::Status ParseJson(absl::string_view json, absl::string_view source,
                       bool ignore_unknown, v1::BundleManifest* manifest) {
  JsonParseOptions options;
  options.ignore_unknown_fields = ignore_unknown;
  manifest->Clear();
  const auto status = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), manifest,
      options);
  if (status.ok()) return absl::OkStatus();
  return Error(source, "manifest", "a bundle's, in JSON",
               std::string(status.message()));
}

absl::Status CheckVersion(const v1::BundleManifest& manifest,
                          absl::string_view source) {
  const int found = manifest.format_version();
  if (found == kBundleFormatVersion) return absl::OkStatus();
  return Error(source, "format_version", absl::StrCat(kBundleFormatVersion),
               absl::StrCat(found, found > kBundleFormatVersion
                                       ? ": written by a newer version of Sinew"
                                       : ""));
}

// Where the digits of the manifest's own digest begin; npos if there are none.
size_t FindDigest(absl::string_view json) {
  const size_t key = json.rfind(kDigestKey);
  if (key == absl::string_view::npos) return key;
  const size_t quote = json.find('"', key + kDigestKey.size());
  if (quote == absl::string_view::npos) return quote;
  if (json.size() < quote + 1 + kDigestSize) return absl::string_view::npos;
  return quote + 1;
}

// The digest of the text with its own digits as zeros.
std::string DigestOf(absl::string_view json, size_t digits) {
  std::string blank(json);
  blank.replace(digits, kDigestSize, kDigestSize, '0');
  return Sha256Hex(blank);
}

absl::Status CheckDigest(absl::string_view json, absl::string_view source) {
  const size_t digits = FindDigest(json);
  if (digits == absl::string_view::npos) {
    return absl::DataLossError(absl::StrCat(
        source,
        ": expected a field manifest_sha256, found none: truncated or "
        "altered"));
  }
  const absl::string_view expected = json.substr(digits, kDigestSize);
  const std::string found = DigestOf(json, digits);
  if (found == expected) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(source, ": expected SHA-256 ", expected,
                   " (manifest_sha256), found ", found, ": altered"));
}

// The same JSON with sorted keys in "files", which protobuf prints in any
// order.
std::string WithSortedFiles(const std::string& text) {
  auto json = nlohmann::ordered_json::parse(text);
  const std::map<std::string, std::string> files = json["files"];
  json["files"] = nlohmann::ordered_json(nlohmann::ordered_json::object());
  for (const auto& [name, digest] : files) json["files"][name] = digest;
  return json.dump(/*indent=*/1) + "\n";
}

}  // namespace

absl::StatusOr<v1::BundleManifest> ParseManifest(absl::string_view json,
                                                 absl::string_view source) {
  v1::BundleManifest manifest;
  // A newer writer's unknown fields must not hide its version.
  SINEW_RETURN_IF_ERROR(
      ParseJson(json, source, /*ignore_unknown=*/true, &manifest));
  SINEW_RETURN_IF_ERROR(CheckVersion(manifest, source));
  SINEW_RETURN_IF_ERROR(CheckDigest(json, source));
  SINEW_RETURN_IF_ERROR(
      ParseJson(json, source, /*ignore_unknown=*/false, &manifest));
  return manifest;
}

absl::StatusOr<std::string> PrintManifest(v1::BundleManifest manifest) {
  manifest.set_manifest_sha256(std::string(kDigestSize, '0'));
  JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto status =
      google::protobuf::util::MessageToJsonString(manifest, &json, options);
  if (!status.ok()) {
    return absl::InternalError(
        absl::StrCat(kManifestFile, ": ", std::string(status.message())));
  }
  json = WithSortedFiles(json);
  const size_t digits = FindDigest(json);
  if (digits == absl::string_view::npos) {
    return absl::InternalError(
        absl::StrCat(kManifestFile, ": no place for its digest"));
  }
  json.replace(digits, kDigestSize, DigestOf(json, digits));
  return json;
}

std::string OnnxFile(absl::string_view graph_name) {
  return absl::StrCat(graph_name, ".onnx");
}

bool IsBundlePath(absl::string_view path) {
  if (path.empty() || path.find('\\') != absl::string_view::npos) return false;
  const std::vector<absl::string_view> names = absl::StrSplit(path, '/');
  return std::all_of(names.begin(), names.end(), [](absl::string_view name) {
    return !name.empty() && name != "." && name != "..";
  });
}

}  // namespace sinew::bundle
