#include "tools/parity/latent_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/policy/latent_graphs.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "proto/sinew/v1/graph.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/parity/bundle_parity.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// What the parts of a bundle say whose graph `edited` moves by 0.01.
LatentParts PartsOf(const std::string& edited) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  auto content = bundle::testing::ToyLatentContent(toy);
  for (v1::Graph& graph : *content.graph.mutable_graphs()) {
    if (graph.name() != edited) continue;
    for (v1::Node& node : *graph.mutable_nodes()) {
      if (node.op() == v1::OP_CLAMP) node.set_high(node.low() + 0.01);
    }
  }
  const std::string folder = JoinPath(toy.folder, "edited");
  EXPECT_THAT(bundle::WriteBundle(content, folder), IsOk());
  const auto bundle = bundle::ReadBundle(folder);
  EXPECT_THAT(bundle, IsOk());
  const auto parts = CompareLatentParts(*bundle, /*rows=*/30, /*seed=*/1);
  EXPECT_THAT(parts, IsOk());
  return parts.value_or(LatentParts{-1, -1});
}

TEST(LatentParts, AreThoseOfTheirOwnBundle) {
  const LatentParts parts = PartsOf("");

  EXPECT_GE(parts.policy, 0);
  EXPECT_GE(parts.sample, 0);
  EXPECT_THAT(CheckLatentParts(parts), IsOk());
}

TEST(LatentParts, AreNotThoseOfAnotherGraph) {
  const LatentParts sample = PartsOf(policy::kSampleGraph);
  EXPECT_LT(sample.policy, kParityTolerance);
  EXPECT_THAT(CheckLatentParts(sample),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("graph \"sample\": tap \"action\""),
                             HasSubstr("within 1e-05, found"))));

  const LatentParts encoder = PartsOf(policy::kEncoderGraph);
  EXPECT_LT(encoder.sample, kParityTolerance);
  EXPECT_THAT(CheckLatentParts(encoder),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("graph \"policy\": tap \"action\"")));
}

}  // namespace
}  // namespace sinew::tools
