#include "learner/service/learner_server.h"

#include <cstddef>

#include "absl/time/clock.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

// As learner/trainer/experience.h promises.
constexpr size_t kKeptSnapshots = 3;

// Of running calls, once there is nothing left to serve.
constexpr absl::Duration kShutdownTimeout = absl::Seconds(1);

std::vector<BlobSource*> SourcesOf(BlobRing& snapshots, BlobSource* assets) {
  std::vector<BlobSource*> sources = {&snapshots};
  if (assets != nullptr) sources.push_back(assets);
  return sources;
}

}  // namespace

LearnerServer::LearnerServer(const Options& options)
    : dispatcher_(Dispatcher::Create(options.dispatcher)),
      snapshots_(kKeptSnapshots),
      sources_(SourcesOf(snapshots_, options.assets)),
      blobs_(sources_) {}

absl::StatusOr<std::unique_ptr<LearnerServer>> LearnerServer::Start(
    const Options& options) {
  std::unique_ptr<LearnerServer> result(new LearnerServer(options));
  std::vector<grpc::Service*> services = {result->dispatcher_->service(),
                                          &result->blobs_};
  services.insert(services.end(), options.services.begin(),
                  options.services.end());
  rpc::Server::Options server;
  server.address = options.listen;
  server.security = options.security;
  SINEW_ASSIGN_OR_RETURN(result->server_, rpc::Server::Start(server, services));
  return result;
}

LearnerServer::~LearnerServer() {
  if (server_ == nullptr) return;
  dispatcher_->Interrupt();
  dispatcher_->Shutdown(absl::Now());
  server_->Shutdown(kShutdownTimeout);
}

void LearnerServer::Interrupt() {
  server_->Drain();
  dispatcher_->Interrupt();
}

void LearnerServer::Drain(absl::Duration timeout) {
  server_->Drain();
  dispatcher_->Shutdown(absl::Now() + timeout);
}

}  // namespace sinew::learner
