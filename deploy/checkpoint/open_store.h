#ifndef SINEW_DEPLOY_CHECKPOINT_OPEN_STORE_H_
#define SINEW_DEPLOY_CHECKPOINT_OPEN_STORE_H_

#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/rpc/credentials.h"
#include "deploy/checkpoint/client/artifact_store.h"

namespace sinew::checkpoint {

enum class StoreAccess { kRead, kWrite };

// The store that a user names: "unix:PATH" and "HOST:PORT" are services,
// anything else (or a folder that is there) is a folder. Borrows the clock.
// Errors: of the address, the credentials, the folder (local_store.h); whether
// a service is there shows at the first call.
absl::StatusOr<std::unique_ptr<ArtifactStore>> OpenStore(
    const std::string& where, StoreAccess access, const rpc::Security& security,
    const Clock& clock, const std::stop_token& stop = {});

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_OPEN_STORE_H_
