#include "deploy/bundle/run_export.h"

#include <string>

#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// A run directory of the toy world, with the snapshot that it came to.
struct FinishedRun {
  FinishedRun() {
    toy = world::testing::MakeToyWorld();
    folder = JoinPath(toy.folder, "run");
    snapshot = SerializeDeterministically(
        testing::RandomSnapshot(toy.recipe, /*observation_width=*/68,
                                /*action_width=*/4));
    EXPECT_THAT(MakeDirectories(folder), IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder, "config.textproto"),
                                    PrintRecipe(toy.recipe)),
                IsOk());
    SaveInputs({});
  }
  void SaveInputs(const std::vector<v1::RunInputs::Source>& sources) const {
    EXPECT_THAT(
        SaveRunInputs(folder, JoinPath(toy.folder, "character.textproto"),
                      *toy.library, sources),
        IsOk());
  }
  absl::Status Export() const {
    return ExportRun(folder,
                     {.snapshot = snapshot, .iterations = 5, .samples = 99},
                     JoinPath(folder, "bundle"));
  }

  world::testing::ToyWorld toy;
  std::string folder;
  std::string snapshot;
};

TEST(ExportRun, NeedsNothingOutsideTheRun) {
  const FinishedRun run;
  ASSERT_THAT(RemoveRecursively(JoinPath(run.toy.folder, "library")), IsOk());
  ASSERT_THAT(RemoveRecursively(JoinPath(run.toy.folder, "toy.xml")), IsOk());

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  const v1::BundleProvenance& provenance = bundle->manifest.provenance();
  EXPECT_EQ(provenance.library_sha256(), run.toy.library->digest());
  EXPECT_EQ(provenance.snapshot_sha256(), Sha256Hex(run.snapshot));
  EXPECT_EQ(provenance.recipe_sha256(), Sha256Hex(PrintRecipe(run.toy.recipe)));
  EXPECT_EQ(provenance.iterations(), 5);
  EXPECT_EQ(provenance.samples(), 99);
  EXPECT_FALSE(bundle->manifest.has_metrics());
}

TEST(ExportRun, NamesTheBundlesItWasMadeFromAndWhatTheyWereTrainedOn) {
  const FinishedRun run;
  v1::BundleManifest teacher;
  teacher.set_manifest_sha256("abc");
  v1::BundleProvenance& provenance = *teacher.mutable_provenance();
  provenance.set_recipe("phc_plus");
  provenance.add_clips("turn: made for tests (Apache-2.0)");
  provenance.add_clips("run: a studio (CC-BY-4.0)");
  provenance.add_data_licences("CC-BY-4.0");
  const v1::RunInputs::Source source = MakeSource("teacher", teacher);
  v1::RunInputs::Source other = source;
  other.mutable_bundle()->set_manifest_sha256("def");
  other.add_labelled_clips("sway");
  other.add_labelled_clips("tumble");
  run.SaveInputs({source, other});

  ASSERT_THAT(run.Export(), IsOk());

  const v1::BundleProvenance made =
      ReadBundle(JoinPath(run.folder, "bundle"))->manifest.provenance();
  ASSERT_EQ(made.sources_size(), 2);
  EXPECT_THAT(made.sources(0),
              EqualsProto("role: \"teacher\" recipe: \"phc_plus\" "
                          "manifest_sha256: \"abc\""));
  EXPECT_THAT(made.sources(1),
              EqualsProto("role: \"teacher\" recipe: \"phc_plus\" "
                          "manifest_sha256: \"def\" "
                          "labelled { clips: [\"sway\", \"tumble\"] }"));
  EXPECT_THAT(made.clips(), ElementsAre("turn: made for tests (Apache-2.0)",
                                        "sway: made for tests (Apache-2.0)",
                                        "tumble: made for tests (Apache-2.0)",
                                        "run: a studio (CC-BY-4.0)"));
  EXPECT_THAT(made.data_licences(), ElementsAre("Apache-2.0", "CC-BY-4.0"));
  // What the teacher does not say of its clips.
  EXPECT_THAT(made.clip_uses(),
              ElementsAre(v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_TRAINED_ON,
                          v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_UNKNOWN));
}

// Of a bundle that was trained on one clip.
v1::BundleManifest ManifestOf(const std::string& clip) {
  v1::BundleManifest manifest;
  manifest.mutable_provenance()->add_clips(clip);
  manifest.mutable_provenance()->add_clip_uses(v1::CLIP_USE_TRAINED_ON);
  return manifest;
}

TEST(ExportRun, SaysWhichClipsWereLeftOutOfTraining) {
  FinishedRun run;
  LeaveOut({1, 2}, run.toy);
  run.SaveInputs(
      {MakeSource("teacher", ManifestOf("tumble: a studio (CC-BY-4.0)"))});

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->manifest.provenance().clips(),
              ElementsAre(StartsWith("turn: "), StartsWith("sway: "),
                          "tumble: made for tests (Apache-2.0)",
                          "tumble: a studio (CC-BY-4.0)"));
  EXPECT_THAT(bundle->manifest.provenance().clip_uses(),
              ElementsAre(v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_LEFT_OUT,
                          v1::CLIP_USE_SOURCE_TRAINED_ON,
                          v1::CLIP_USE_SOURCE_TRAINED_ON));
}

// Another recording of the same name was not trained on, but by the teacher.
TEST(ExportRun, TellsItsOwnClipsFromOthersOfTheirName) {
  FinishedRun run;
  run.SaveInputs(
      {MakeSource("teacher", ManifestOf("turn: a studio (CC-BY-4.0)"))});

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(
      bundle->manifest.provenance().clips(),
      ElementsAre(StartsWith("turn: "), StartsWith("sway: "),
                  StartsWith("tumble: "), "turn: a studio (CC-BY-4.0)"));
  EXPECT_THAT(
      bundle->manifest.provenance().clip_uses(),
      ElementsAre(v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_TRAINED_ON,
                  v1::CLIP_USE_TRAINED_ON, v1::CLIP_USE_SOURCE_TRAINED_ON));
}

TEST(ExportRun, TakesItsOwnEarlierTrainingForNoOtherBundle) {
  FinishedRun run;
  LeaveOut({1}, run.toy);
  v1::RunInputs::Source itself;
  itself.add_clips("sway: made for tests (Apache-2.0)");
  itself.add_clip_uses(v1::CLIP_USE_TRAINED_ON);
  run.SaveInputs({itself});

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  const v1::BundleProvenance& made = bundle->manifest.provenance();
  EXPECT_EQ(made.sources_size(), 0);
  EXPECT_THAT(made.data_licences(), ElementsAre("Apache-2.0"));
  EXPECT_THAT(made.clip_uses(), ElementsAre(v1::CLIP_USE_TRAINED_ON,
                                            v1::CLIP_USE_SOURCE_TRAINED_ON,
                                            v1::CLIP_USE_TRAINED_ON));
}

TEST(ExportRun, SaysThatTheLicencesOfATeacherElsewhereAreUnknown) {
  const FinishedRun run;
  v1::RunInputs::Source source;
  source.mutable_bundle()->set_role("teacher");
  source.mutable_bundle()->set_manifest_sha256("abc");
  run.SaveInputs({source});

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->manifest.provenance().data_licences(),
              ElementsAre("Apache-2.0", "unknown"));
}

// A frozen copy of the graph "policy", as a run has whose teacher acts at
// times.
void AddTeacher(v1::Snapshot& snapshot) {
  TensorMap weights = *ParseSafetensors(snapshot.weights(), "snapshot");
  v1::PolicyGraph& graph = *snapshot.mutable_graph();
  v1::Graph teacher = graph.graphs(0);
  teacher.set_name("teacher");
  for (v1::Node& node : *teacher.mutable_nodes()) {
    for (std::string& parameter : *node.mutable_parameters()) {
      parameter = "teacher/" + parameter;
    }
  }
  const v1::PolicyGraph before = graph;
  *graph.add_graphs() = teacher;
  for (const v1::Parameter& parameter : before.parameters()) {
    v1::Parameter& copy = *graph.add_parameters();
    copy = parameter;
    copy.set_name("teacher/" + parameter.name());
    weights["teacher/" + parameter.name()] = weights.at(parameter.name());
  }
  snapshot.set_weights(SerializeSafetensors(weights));
}

TEST(ExportRun, LeavesATeacherInTheSnapshotOut) {
  FinishedRun run;
  v1::Snapshot snapshot;
  ASSERT_TRUE(snapshot.ParseFromString(run.snapshot));
  AddTeacher(snapshot);
  run.snapshot = SerializeDeterministically(snapshot);

  ASSERT_THAT(run.Export(), IsOk());

  const auto bundle = ReadBundle(JoinPath(run.folder, "bundle"));
  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->manifest.graphs(), ElementsAre("policy"));
  for (const auto& [name, tensor] : bundle->weights) {
    EXPECT_THAT(name, Not(StartsWith("teacher/")));
  }
}

TEST(ExportRun, WritesMetricsWhereThereAreSome) {
  const FinishedRun run;
  v1::BundleMetrics metrics;
  metrics.set_starts(32);
  metrics.set_e_g_mpjpe_mm(31.5);

  ASSERT_THAT(
      ExportRun(run.folder, {.snapshot = run.snapshot, .metrics = metrics},
                JoinPath(run.folder, "bundle")),
      IsOk());

  EXPECT_EQ(
      ReadBundle(JoinPath(run.folder, "bundle"))->manifest.metrics().starts(),
      32);
}

TEST(ExportRun, NamesWhatTheRunLacks) {
  const FinishedRun run;
  ASSERT_THAT(RemoveRecursively(JoinPath(run.folder, "inputs")), IsOk());

  EXPECT_THAT(run.Export(), StatusIs(absl::StatusCode::kNotFound,
                                     HasSubstr("inputs/inputs.textproto")));
  EXPECT_THAT(
      ExportRun("/nowhere", {.snapshot = run.snapshot}, "/nowhere/bundle"),
      StatusIs(absl::StatusCode::kNotFound,
               HasSubstr("/nowhere/config.textproto")));
}

TEST(ExportRun, RefusesACharacterThatWasEdited) {
  const FinishedRun run;
  const std::string path = JoinPath(run.folder, "inputs/character/toy.xml");
  ASSERT_THAT(WriteFileAtomically(
                  path, absl::StrReplaceAll(*ReadFile(path),
                                            {{"mass=\"6\"", "mass=\"7\""}})),
              IsOk());

  EXPECT_THAT(run.Export(),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("altered since the run started")));
}

TEST(ExportRun, RefusesASnapshotThatIsNone) {
  const FinishedRun run;

  EXPECT_THAT(ExportRun(run.folder, {.snapshot = "no snapshot"},
                        JoinPath(run.folder, "bundle")),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("snapshot: expected a v1.Snapshot")));
}

TEST(SaveRunInputs, RefusesALibraryOfAnotherCharacter) {
  const FinishedRun run;

  EXPECT_THAT(SaveRunInputs(run.folder, "humanoid", *run.toy.library),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("digest")));
}

}  // namespace
}  // namespace sinew::bundle
