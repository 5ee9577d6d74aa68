#include "deploy/bundle/run_export.h"

#include <string>

#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

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
    EXPECT_THAT(
        SaveRunInputs(folder, JoinPath(toy.folder, "character.textproto"),
                      *toy.library),
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
