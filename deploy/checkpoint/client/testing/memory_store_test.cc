#include "deploy/checkpoint/client/testing/memory_store.h"

#include <memory>

#include "deploy/checkpoint/client/testing/store_conformance.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

class InMemory : public StoreFixture {
 public:
  ArtifactStore& store() override { return store_; }

 private:
  MemoryStore store_;
};

INSTANTIATE_TEST_SUITE_P(Memory, StoreConformance,
                         ::testing::Values(StoreMaker([] {
                           return std::make_unique<InMemory>();
                         })));

}  // namespace
}  // namespace sinew::checkpoint
