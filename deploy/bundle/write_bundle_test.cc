// Bundles are written whole, and read back equal.
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/world/action.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::ElementsAre;
using testing::FilesOf;
using ::testing::HasSubstr;
using testing::Toy;
using testing::WriteToy;

TEST(WriteBundle, ReadsBackWhatWasWritten) {
  const BundleContent content = testing::ToyContent(Toy());

  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->graph, EqualsProto(content.graph));
  EXPECT_EQ(SerializeSafetensors(bundle->weights),
            SerializeSafetensors(content.weights));
  EXPECT_EQ(bundle->character->digest(), Toy().character->digest());
  EXPECT_THAT(bundle->manifest.graphs(), ElementsAre("policy"));
  EXPECT_EQ(bundle->manifest.joints(2).name(), "hip_fr");
  EXPECT_EQ(bundle->manifest.joints(2).stiffness(), 100);
  EXPECT_EQ(bundle->manifest.bodies(0), "trunk");
  EXPECT_EQ(bundle->manifest.control_hz(), 30);
  EXPECT_EQ(bundle->manifest.action_width(), 4);
  EXPECT_EQ(bundle->manifest.observation_width(), 33 + 35);
  EXPECT_THAT(bundle->manifest.provenance().clips(),
              ElementsAre("turn: made for tests (Apache-2.0)",
                          "sway: made for tests (Apache-2.0)",
                          "tumble: made for tests (Apache-2.0)"));
  EXPECT_THAT(bundle->manifest.provenance().clip_uses(),
              ElementsAre(v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_TRAINED_ON,
                          v1::CLIP_USE_TRAINED_ON));
  EXPECT_THAT(bundle->manifest.provenance().data_licences(),
              ElementsAre("Apache-2.0"));
  EXPECT_EQ(bundle->manifest.provenance().library_sha256(),
            Toy().library->digest());
}

// What a robot team computes: from the manifest, without the character's files.
double TargetOf(const v1::BundleManifest& manifest, int j, float action) {
  const v1::BundleJoint& joint = manifest.joints(j);
  const v1::Action& law = manifest.action();
  const double strength =
      law.strength_scale() * joint.torque_limit() / joint.stiffness();
  const double scale = joint.action_scale() > 0 ? joint.action_scale()
                       : strength > 0           ? strength
                                                : law.scale();
  const double unit =
      std::clamp(static_cast<double>(action), -law.clip(), law.clip());
  return std::clamp(joint.default_position() + scale * unit,
                    joint.lower() - law.range_margin(),
                    joint.upper() + law.range_margin());
}

TEST(WriteBundle, SaysAllThatTakesAnActionToATarget) {
  const auto bundle = ReadBundle(WriteToy());
  ASSERT_THAT(bundle, IsOk());
  ASSERT_EQ(bundle->manifest.joints_size(), 4);
  EXPECT_EQ(bundle->manifest.joints(2).action_scale(), 0.3);
  EXPECT_TRUE(bundle->manifest.joints(0).has_action_scale());
  const world::ActionLaw law(Toy().recipe.task().action(),
                             Toy().character->joints());
  const std::vector<double> q(4, 0.2);
  for (const float unit : {-40.0F, -0.7F, 0.0F, 1.3F, 40.0F}) {
    const std::vector<float> action(4, unit);
    std::vector<double> targets(4);
    // Where no reference is to be seen, around the default pose.
    law.Target(q, /*next=*/nullptr, action, absl::MakeSpan(targets));

    for (int j = 0; j < 4; ++j) {
      EXPECT_DOUBLE_EQ(TargetOf(bundle->manifest, j, unit), targets[j]) << unit;
    }
  }
}

TEST(WriteBundle, GivesBackTheRecipeOfItsTask) {
  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  const v1::Recipe recipe = TaskRecipe(bundle->manifest);
  EXPECT_THAT(recipe.task(), EqualsProto(Toy().recipe.task()));
  EXPECT_THAT(recipe.physics(), EqualsProto(Toy().recipe.physics()));
}

TEST(WriteBundle, LeavesAllClipsToWhatIsDoneWithIt) {
  BundleContent content = testing::ToyContent(Toy());
  v1::Start& start = *content.manifest.mutable_task()->mutable_start();
  start.add_only_clips("sway");
  start.set_other_clips_share(0.25);

  ASSERT_THAT(WriteBundle(content, TestPath("only")), IsOk());

  const auto bundle = ReadBundle(TestPath("only"));
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.task().start().only_clips_size(), 1);
  EXPECT_THAT(TaskRecipe(bundle->manifest).task(),
              EqualsProto(Toy().recipe.task()));
}

TEST(WriteBundle, GivesBackWhenAnEvaluationFails) {
  const BundleContent usual = testing::ToyContent(Toy());
  EXPECT_FALSE(usual.manifest.has_max_mean_body_distance());
  EXPECT_EQ(TaskRecipe(usual.manifest).evaluation().max_mean_body_distance(),
            0.5);
  v1::Recipe recipe = Toy().recipe;
  recipe.mutable_evaluation()->set_max_mean_body_distance(0.25);
  BundleContent content =
      testing::ToyContent(world::testing::MakeToyWorld(recipe));
  ASSERT_THAT(WriteBundle(content, TestPath("strict")), IsOk());

  const auto bundle = ReadBundle(TestPath("strict"));

  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(TaskRecipe(bundle->manifest).evaluation().max_mean_body_distance(),
            0.25);
  content.manifest.set_max_mean_body_distance(-1);
  EXPECT_THAT(
      WriteBundle(content, TestPath("strict")),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("evaluation.max_mean_body_distance: expected")));
}

// A rule of starts that a recipe may have only beside evaluations.
TEST(WriteBundle, TakesPoliciesWhoseStartsFollowedEvaluations) {
  for (const v1::Start::Rule rule :
       {v1::Start::RULE_PHC_SOFT, v1::Start::RULE_PHC_HARD}) {
    BundleContent content = testing::ToyContent(Toy());
    content.manifest.mutable_task()->mutable_start()->set_rule(rule);

    ASSERT_THAT(WriteBundle(content, TestPath("phc")), IsOk());

    const auto bundle = ReadBundle(TestPath("phc"));
    ASSERT_THAT(bundle, IsOk());
    EXPECT_EQ(TaskRecipe(bundle->manifest).task().start().rule(), rule);
  }
}

TEST(WriteBundle, SameContentGivesSameBytes) {
  const std::string a = WriteToy("a");
  const std::string b = WriteToy("b");

  for (const std::string& file : FilesOf(a)) {
    EXPECT_EQ(*ReadFile(JoinPath(a, file)), *ReadFile(JoinPath(b, file)))
        << file;
  }
}

TEST(WriteBundle, ReplacesTheOldOneAndLeavesNothingElse) {
  const std::string directory = WriteToy();
  const BundleContent content = testing::ToyContent(Toy(), /*gain=*/0.5);

  EXPECT_THAT(WriteBundle(content, directory), IsOk());

  const auto bundle = ReadBundle(directory);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(SerializeSafetensors(bundle->weights),
            SerializeSafetensors(content.weights));
  EXPECT_THAT(*ListDirectory(TestPath("")), ElementsAre("toy"));
}

TEST(WriteBundle, LeavesAFolderAloneThatHoldsSomethingElse) {
  const BundleContent content = testing::ToyContent(Toy());
  for (const std::string folder : {"mine", "beside.part"}) {
    const std::string file = JoinPath(TestPath(folder), "thesis.txt");
    ASSERT_THAT(MakeDirectories(TestPath(folder)), IsOk());
    ASSERT_THAT(WriteFileAtomically(file, "years"), IsOk());

    EXPECT_THAT(
        WriteBundle(content, TestPath(folder == "mine" ? "mine" : "beside")),
        StatusIs(absl::StatusCode::kFailedPrecondition,
                 HasSubstr(absl::StrCat(TestPath(folder),
                                        ": expected a bundle, an empty folder "
                                        "or none, found one that holds "
                                        "thesis.txt"))));

    EXPECT_THAT(ReadFile(file), IsOkAndHolds("years"));
  }
}

TEST(WriteBundle, TakesAnEmptyFolder) {
  ASSERT_THAT(MakeDirectories(TestPath("empty")), IsOk());

  EXPECT_THAT(WriteBundle(testing::ToyContent(Toy()), TestPath("empty")),
              IsOk());

  EXPECT_THAT(ReadBundle(TestPath("empty")), IsOk());
}

TEST(WriteBundle, RefusesContentThatReadBundleWould) {
  const std::string directory = WriteToy();
  const std::string before = *ReadFile(JoinPath(directory, kManifestFile));
  BundleContent content = testing::ToyContent(Toy());
  content.manifest.mutable_joints(0)->set_name("tail");

  EXPECT_THAT(WriteBundle(content, directory),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("tail")));

  EXPECT_EQ(*ReadFile(JoinPath(directory, kManifestFile)), before);
  EXPECT_THAT(*ListDirectory(TestPath("")), ElementsAre("toy"));
}

TEST(WriteBundle, KeepsTheOldOneWhenTheDiskIsFull) {
  const std::string directory = WriteToy();
  const std::string before = *ReadFile(JoinPath(directory, kManifestFile));
  const BundleContent content = testing::ToyContent(Toy(), /*gain=*/0.5);
  // No file may grow beyond 8 KiB: the nearest to a full disk without a mount.
  const sighandler_t handler = signal(SIGXFSZ, SIG_IGN);
  rlimit limit;
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small = {8192, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);

  const absl::Status status = WriteBundle(content, directory);

  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, handler);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(*ReadFile(JoinPath(directory, kManifestFile)), before);
  EXPECT_THAT(ReadBundle(directory), IsOk());
  EXPECT_THAT(*ListDirectory(TestPath("")), ElementsAre("toy"));
}

int64_t SizeOf(const std::string& directory) {
  int64_t size = 0;
  for (const std::string& file : FilesOf(directory)) {
    size += *FileSize(JoinPath(directory, file));
  }
  return size;
}

TEST(WriteBundle, OurCharactersAreSmallAndStandAlone) {
  for (const std::string name : {"humanoid", "g1"}) {
    const BundleContent content =
        testing::CharacterContent(name, WithDefaults(v1::Recipe()));
    const std::string directory = TestPath(name);

    ASSERT_THAT(WriteBundle(content, directory), IsOk());

    EXPECT_LT(SizeOf(directory), 8 << 20) << name;
    for (const std::string& file : FilesOf(directory)) {
      EXPECT_FALSE(absl::EndsWithIgnoreCase(file, ".stl")) << file;
    }
    ::testing::Test::RecordProperty(name + "_bytes",
                                    static_cast<int>(SizeOf(directory)));
  }
}

}  // namespace
}  // namespace sinew::bundle
