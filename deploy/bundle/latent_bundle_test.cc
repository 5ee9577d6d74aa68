// Bundles with a latent: a model for each graph, widths that fit, all graphs or
// none.
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/select_graphs.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/latent_graphs.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const char* const kAllGraphs[] = {"policy", "encoder", "prior", "decoder",
                                  "sample"};

const world::testing::ToyWorld& Toy() {
  static const auto* toy = new world::testing::ToyWorld(
      world::testing::MakeToyWorld(testing::ToyLatentRecipe()));
  return *toy;
}

std::string Folder() { return sinew::testing::TestPath("bundle"); }

std::string WriteToy() {
  EXPECT_THAT(WriteBundle(testing::ToyLatentContent(Toy()), Folder()), IsOk());
  return Folder();
}

absl::Status WriteEdited(const std::function<void(BundleContent&)>& edit) {
  BundleContent content = testing::ToyLatentContent(Toy());
  edit(content);
  return WriteBundle(content, Folder());
}

TEST(LatentBundle, NamesItsGraphsAndWidths) {
  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->manifest.graphs(),
              ElementsAre("policy", "encoder", "prior", "decoder", "sample"));
  EXPECT_EQ(bundle->manifest.self_observation_width(), 33);
  EXPECT_EQ(bundle->manifest.latent_width(), 6);
  EXPECT_TRUE(HasLatent(*bundle));
}

TEST(LatentBundle, HasAModelOfEachGraphThatPointsIntoTheWeights) {
  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  for (const char* graph : kAllGraphs) {
    const auto model = ReadFile(bundle->onnx_file(graph));
    ASSERT_THAT(model, IsOk());
    EXPECT_THAT(*model, HasSubstr("weights.safetensors")) << graph;
    EXPECT_TRUE(bundle->manifest.files().contains(OnnxFile(graph))) << graph;
  }
}

TEST(LatentBundle, RefusesAnEditedModelOfAnyGraph) {
  const std::string directory = WriteToy();
  for (const char* graph : kAllGraphs) {
    const std::string path = JoinPath(directory, OnnxFile(graph));
    const std::string whole = *ReadFile(path);
    std::string edited = whole;
    edited[whole.size() / 2] ^= 1;
    ASSERT_THAT(WriteFileAtomically(path, edited), IsOk());

    EXPECT_THAT(ReadBundle(directory),
                StatusIs(absl::StatusCode::kDataLoss,
                         HasSubstr(absl::StrCat(path, ": expected SHA-256"))));

    ASSERT_THAT(WriteFileAtomically(path, whole), IsOk());
  }
}

TEST(LatentBundle, NamesTheModelThatIsMissing) {
  const std::string directory = WriteToy();
  for (const char* graph : kAllGraphs) {
    const std::string path = JoinPath(directory, OnnxFile(graph));
    const std::string whole = *ReadFile(path);
    ASSERT_THAT(RemoveRecursively(path), IsOk());

    EXPECT_THAT(ReadBundle(directory),
                StatusIs(absl::StatusCode::kNotFound, HasSubstr(path)));

    ASSERT_THAT(WriteFileAtomically(path, whole), IsOk());
  }
}

TEST(LatentBundle, NamesTheGraphThatItLacks) {
  for (const char* graph : {"encoder", "prior", "decoder", "sample"}) {
    EXPECT_THAT(
        WriteEdited([&](BundleContent& content) {
          content.graph = policy::GraphsWithout(content.graph, {graph});
        }),
        StatusIs(
            absl::StatusCode::kInvalidArgument,
            AllOf(HasSubstr("graph.textproto"),
                  HasSubstr(absl::StrCat("expected a graph \"", graph,
                                         "\", as bundles with a latent")))));
  }
}

TEST(LatentBundle, RefusesAManifestWithOtherWidths) {
  EXPECT_THAT(
      WriteEdited([](BundleContent& content) {
        content.manifest.set_self_observation_width(32);
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("self_observation_width: expected 33, found 32")));
  EXPECT_THAT(WriteEdited([](BundleContent& content) {
                content.manifest.set_latent_width(5);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("latent_width: expected 6, found 5")));
}

TEST(LatentBundle, RefusesGraphsThatSeeAnotherPartOfTheObservation) {
  EXPECT_THAT(
      WriteEdited([](BundleContent& content) {
        content.graph = testing::LatentGraphs({.self = 30});
        content.weights = testing::LatentWeights({.self = 30});
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("graph \"prior\": inputs: expected self_observation "
                         "[33], found self_observation [30]")));
}

TEST(LatentBundle, RefusesAGraphWithoutTheTapThatIsAskedFor) {
  EXPECT_THAT(WriteEdited([](BundleContent& content) {
                content.graph.mutable_graphs(2)->mutable_taps(1)->set_name("s");
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("graph \"prior\": taps: expected std [6], "
                                 "found none of that name")));
  EXPECT_THAT(
      WriteEdited([](BundleContent& content) {
        content.graph.mutable_graphs(3)->mutable_taps(0)->set_executed(false);
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("graph \"decoder\": taps: expected action [4] "
                         "executed, found action [4]")));
}

TEST(LatentBundle, RefusesALawThatNeedsAReference) {
  EXPECT_THAT(
      WriteEdited([](BundleContent& content) {
        const auto placement = v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
        content.manifest.mutable_action()->set_placement(placement);
        content.manifest.mutable_task()->mutable_action()->set_placement(
            placement);
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("manifest.json: action.placement: expected "
                         "PLACEMENT_ABSOLUTE or PLACEMENT_AROUND_")));
}

TEST(LatentBundle, RefusesAGraphWhoseNameLeavesTheFolder) {
  EXPECT_THAT(WriteEdited([](BundleContent& content) {
                content.graph.mutable_graphs(4)->set_name("../sample");
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("graphs: expected a name that a file may "
                                 "have, found \"../sample\"")));
}

TEST(LatentBundle, IsNoneWithoutItsGraphs) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  ASSERT_THAT(WriteBundle(testing::ToyContent(toy), Folder()), IsOk());

  const auto bundle = ReadBundle(Folder());

  ASSERT_THAT(bundle, IsOk());
  EXPECT_FALSE(HasLatent(*bundle));
  EXPECT_EQ(bundle->manifest.self_observation_width(), 0);
  EXPECT_FALSE(FileExists(bundle->onnx_file("encoder")));
}

// The same manifest as written before there were latents and sources.
std::string OlderManifest(const std::string& text) {
  auto json = nlohmann::ordered_json::parse(text);
  json.erase("self_observation_width");
  json.erase("latent_width");
  json["provenance"].erase("sources");
  json["manifest_sha256"] = std::string(64, '0');
  const std::string blank = json.dump(/*indent=*/1) + "\n";
  json["manifest_sha256"] = Sha256Hex(blank);
  return json.dump(/*indent=*/1) + "\n";
}

TEST(LatentBundle, ManifestsFromBeforeThereWereLatentsAreRead) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  ASSERT_THAT(WriteBundle(testing::ToyContent(toy), Folder()), IsOk());
  const std::string path = JoinPath(Folder(), kManifestFile);
  const std::string older = OlderManifest(*ReadFile(path));
  ASSERT_THAT(older, AllOf(Not(HasSubstr("latent_width")),
                           Not(HasSubstr("\"sources\""))));
  ASSERT_THAT(WriteFileAtomically(path, older), IsOk());

  const auto bundle = ReadBundle(Folder());

  ASSERT_THAT(bundle, IsOk());
  EXPECT_FALSE(HasLatent(*bundle));
}

}  // namespace
}  // namespace sinew::bundle
