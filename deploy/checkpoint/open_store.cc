#include "deploy/checkpoint/open_store.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/rpc/address.h"
#include "common/rpc/channel.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/checkpoint_client.h"
#include "deploy/checkpoint/local_store.h"

namespace sinew::checkpoint {
namespace {

bool IsAddress(const std::string& where) {
  if (absl::StartsWith(where, "unix:")) return true;
  return !absl::StrContains(where, '/') && !FileExists(where) &&
         rpc::ParseAddress(where).ok();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ArtifactStore>> OpenStore(
    const std::string& where, StoreAccess access, const rpc::Security& security,
    const Clock& clock, const std::stop_token& stop) {
  if (!IsAddress(where)) {
    if (access == StoreAccess::kRead) {
      return LocalStore::OpenReadOnly(where, clock);
    }
    return LocalStore::Open(where, clock);
  }
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                         rpc::MakeChannel(where, security));
  CheckpointClient::Options options;
  options.peer = absl::StrCat("checkpoint ", where);
  options.stop = stop;
  return std::make_unique<CheckpointClient>(std::move(channel),
                                            std::move(options));
}

}  // namespace sinew::checkpoint
