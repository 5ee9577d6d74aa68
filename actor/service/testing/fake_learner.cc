#include "actor/service/testing/fake_learner.h"

#include <utility>

#include "absl/time/time.h"
#include "common/check.h"
#include "common/digest.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "replay/testing/segments.h"

namespace sinew::actor {

FakeLearner::FakeLearner(const std::string& address,
                         const std::map<std::string, std::string>& assets,
                         int64_t replay_bytes)
    : assets_sha256_(PublishAssets(assets)),
      replay_(replay_bytes),
      dispatcher_(MakeWelcome()) {
  auto server =
      rpc::Server::Start({.address = address},
                         {&dispatcher_, &blobs_service_, &replay_.service()});
  SINEW_CHECK(server.ok()) << server.status().ToString();
  server_ = *std::move(server);
  const absl::Status opened =
      replay_.Open(replay::MakeOpen({}, 0, /*reset=*/true));
  SINEW_CHECK(opened.ok()) << opened.ToString();
}

FakeLearner::~FakeLearner() {
  replay_.Close();
  server_->Shutdown(absl::ZeroDuration());
}

std::string FakeLearner::Publish(const std::string& bytes) {
  return blobs_.Put(bytes);
}

std::string FakeLearner::PublishAssets(
    const std::map<std::string, std::string>& assets) {
  v1::TaskAssets list;
  for (const auto& [role, bytes] : assets) {
    v1::Asset* asset = list.add_assets();
    asset->set_role(role);
    asset->set_sha256(Publish(bytes));
    asset->set_size(static_cast<int64_t>(bytes.size()));
  }
  return Publish(SerializeDeterministically(list));
}

v1::DispatcherMessage::Welcome FakeLearner::MakeWelcome() const {
  v1::DispatcherMessage::Welcome welcome;
  welcome.set_run_id(replay::kRun);
  welcome.set_heartbeat_seconds(0.01);
  welcome.set_assets_sha256(assets_sha256_);
  return welcome;
}

}  // namespace sinew::actor
