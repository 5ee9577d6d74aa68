#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_STORE_CONFORMANCE_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_STORE_CONFORMANCE_H_

#include <functional>
#include <memory>

#include "deploy/checkpoint/client/artifact_store.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {

// A new, empty store and what it needs.
class StoreFixture {
 public:
  virtual ~StoreFixture() = default;
  virtual ArtifactStore& store() = 0;
};
using StoreMaker = std::function<std::unique_ptr<StoreFixture>()>;

// What every ArtifactStore is held to:
//
//   INSTANTIATE_TEST_SUITE_P(Local, StoreConformance,
//                            ::testing::Values(StoreMaker(...)));
class StoreConformance : public ::testing::TestWithParam<StoreMaker> {
 protected:
  ArtifactStore& store() { return fixture_->store(); }

 private:
  const std::unique_ptr<StoreFixture> fixture_ = GetParam()();
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_STORE_CONFORMANCE_H_
