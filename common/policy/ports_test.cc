#include "common/policy/ports.h"

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::PolicyGraph Graph() {
  return *BuildTrackingPolicy(
      {.observation_width = 7,
       .action_width = 3,
       .network = WithDefaults(v1::Recipe()).network()});
}

TEST(Ports, AreFoundByWhatTheyAre) {
  const auto ports = FindPorts(Graph(), "policy");

  ASSERT_THAT(ports, IsOk());
  EXPECT_EQ(ports->observation, "observation");
  EXPECT_EQ(ports->observation_width, 7);
  EXPECT_THAT(ports->noise, ElementsAre("noise"));
  EXPECT_EQ(ports->action, "action");
  EXPECT_EQ(ports->action_width, 3);
}

TEST(Ports, NeedAnExecutedTap) {
  EXPECT_THAT(FindPorts(Graph(), "critic"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("graph \"critic\": expected an executed tap, "
                                 "found none")));
}

TEST(Ports, NeedOneDataInput) {
  v1::PolicyGraph two = Graph();
  v1::GraphInput* input = two.mutable_graphs(0)->add_inputs();
  input->set_name("latent");
  input->set_width(2);
  input->set_kind(v1::GraphInput::KIND_DATA);

  EXPECT_THAT(FindPorts(two, "policy"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected one data input, found "
                                 "\"observation\" and \"latent\"")));
}

TEST(Ports, NeedAGraphOfThatName) {
  EXPECT_THAT(FindPorts(Graph(), "prior"),
              StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace sinew::policy
