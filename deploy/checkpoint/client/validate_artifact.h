#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_VALIDATE_ARTIFACT_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_VALIDATE_ARTIFACT_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::checkpoint {

// What every store refuses, so that names are safe as file names. Thread-safe
// pure functions. Errors: INVALID_ARGUMENT naming field, expected and found.

// Ids and aliases: [A-Za-z0-9._-]{1,128}, no dot in front. `what` is "artifact
// id" or "alias".
absl::Status ValidateName(absl::string_view what, absl::string_view name);

// [a-z_]{1,32}.
absl::Status ValidateKind(absl::string_view kind);

// INVALID_ARGUMENT unless it is 64 lower-case hex digits.
absl::Status ValidateDigest(absl::string_view sha256);

// Id, kind, 1 to 10 000 files with relative paths that are sorted, unique and
// no folder of each other, digests, sizes.
absl::Status ValidateArtifact(const v1::Artifact& artifact);

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_VALIDATE_ARTIFACT_H_
