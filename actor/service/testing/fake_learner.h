#ifndef SINEW_ACTOR_SERVICE_TESTING_FAKE_LEARNER_H_
#define SINEW_ACTOR_SERVICE_TESTING_FAKE_LEARNER_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "actor/service/testing/fake_dispatcher.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blobs_service.h"
#include "common/rpc/server.h"
#include "replay/testing/test_replay.h"

namespace sinew::actor {

// What an actor needs of a learner, in one server: a fake dispatcher, blobs,
// and the real replay with an empty table of run kRun.
//
// Thread-safety: any thread. Members abort with a message on any error.
class FakeLearner {
 public:
  // Serves these assets, by role, at `address` ("127.0.0.1:0").
  FakeLearner(const std::string& address,
              const std::map<std::string, std::string>& assets,
              int64_t replay_bytes = int64_t{1} << 30);
  ~FakeLearner();

  // Makes bytes available for fetching; returns their digest.
  std::string Publish(const std::string& bytes);

  FakeDispatcher& dispatcher() { return dispatcher_; }
  replay::TestReplay& replay() { return replay_; }
  const std::string& address() const { return server_->address(); }
  const std::string& assets_sha256() const { return assets_sha256_; }

 private:
  std::string PublishAssets(const std::map<std::string, std::string>& assets);
  v1::DispatcherMessage::Welcome MakeWelcome() const;

  BlobRing blobs_{1024};
  const std::string assets_sha256_;
  replay::TestReplay replay_;
  FakeDispatcher dispatcher_;
  BlobsService blobs_service_{blobs_};
  std::unique_ptr<rpc::Server> server_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_TESTING_FAKE_LEARNER_H_
