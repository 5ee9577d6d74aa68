#include "deploy/checkpoint/client/validate_artifact.h"

#include <set>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::checkpoint {
namespace {

constexpr size_t kMaxName = 128;
constexpr size_t kMaxKind = 32;
constexpr size_t kMaxPath = 255;
constexpr int kMaxFiles = 10'000;

absl::Status Expected(absl::string_view what, absl::string_view expected,
                      absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(what, ": expected ", expected, ", found \"",
                   absl::CHexEscape(found.substr(0, 2 * kMaxPath)), "\""));
}

absl::Status ValidatePath(absl::string_view path) {
  bool good = !path.empty() && path.size() <= kMaxPath;
  for (absl::string_view part : absl::StrSplit(path, '/')) {
    good = good && !part.empty() && part != "." && part != ".." &&
           !IsTemporaryName(part);
  }
  for (const char c : path) good = good && c != '\\' && absl::ascii_isprint(c);
  if (good) return absl::OkStatus();
  return Expected("path",
                  "a relative path of at most 255 printable characters, "
                  "without \"..\"",
                  path);
}

// `paths` are those of the files before.
absl::Status ValidateFile(const v1::Artifact::File& file,
                          const std::set<std::string>& paths) {
  SINEW_RETURN_IF_ERROR(ValidatePath(file.path()));
  if (!paths.empty() && file.path() <= *paths.rbegin()) {
    return Expected("path", absl::StrCat("one after \"", *paths.rbegin(), "\""),
                    file.path());
  }
  for (size_t slash = file.path().find('/'); slash != std::string::npos;
       slash = file.path().find('/', slash + 1)) {
    const std::string folder = file.path().substr(0, slash);
    if (!paths.contains(folder)) continue;
    return Expected("path", absl::StrCat("\"", folder, "\" to be a file"),
                    file.path());
  }
  SINEW_RETURN_IF_ERROR(ValidateDigest(file.sha256()));
  if (file.size() >= 0) return absl::OkStatus();
  return Expected("size", ">= 0", absl::StrCat(file.size()));
}

}  // namespace

absl::Status ValidateName(absl::string_view what, absl::string_view name) {
  bool good = !name.empty() && name.size() <= kMaxName && name[0] != '.' &&
              !IsTemporaryName(name);
  for (const char c : name) {
    good = good && (absl::ascii_isalnum(c) || c == '.' || c == '_' || c == '-');
  }
  if (good) return absl::OkStatus();
  return Expected(what, "[A-Za-z0-9._-]{1,128} without a dot in front", name);
}

absl::Status ValidateKind(absl::string_view kind) {
  bool good = !kind.empty() && kind.size() <= kMaxKind;
  for (const char c : kind) good = good && (absl::ascii_islower(c) || c == '_');
  if (good) return absl::OkStatus();
  return Expected("kind", "[a-z_]{1,32}", kind);
}

absl::Status ValidateDigest(absl::string_view sha256) {
  if (IsSha256Hex(sha256)) return absl::OkStatus();
  return Expected("digest", "a SHA-256", sha256);
}

absl::Status ValidateArtifact(const v1::Artifact& artifact) {
  SINEW_RETURN_IF_ERROR(ValidateName("artifact id", artifact.id()));
  const std::string name = absl::StrCat("artifact ", artifact.id(), ": ");
  absl::Status status = ValidateKind(artifact.kind());
  if (artifact.files_size() < 1 || artifact.files_size() > kMaxFiles) {
    status.Update(Expected("files", absl::StrCat("1 to ", kMaxFiles),
                           absl::StrCat(artifact.files_size())));
  }
  std::set<std::string> paths;
  for (const v1::Artifact::File& file : artifact.files()) {
    if (!status.ok()) break;
    status = ValidateFile(file, paths);
    paths.insert(file.path());
  }
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat(name, status.message()));
}

}  // namespace sinew::checkpoint
