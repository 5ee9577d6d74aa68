#include "tools/sinew/export_command.h"

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/run_export.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "deploy/checkpoint/service/checkpoint_server.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/procedure/procedure.h"
#include "learner/state/state_store.h"
#include "learner/trainer/trainer.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/compact_state.h"
#include "tools/training/procedure_record.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A run directory as training leaves it, without the training.
class ExportCommand : public ::testing::Test {
 protected:
  ExportCommand()
      : toy_(world::testing::MakeToyWorld()),
        run_(JoinPath(toy_.folder, "run")) {
    EXPECT_THAT(MakeDirectories(JoinPath(run_, "checkpoints")), IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(run_, "config.textproto"),
                                    PrintRecipe(toy_.recipe)),
                IsOk());
    SaveInputs({}, "");
  }

  void SaveInputs(const std::vector<v1::RunInputs::Source>& sources,
                  const std::string& assets) const {
    ASSERT_THAT(bundle::SaveRunInputs(
                    run_, JoinPath(toy_.folder, "character.textproto"),
                    *toy_.library, sources, assets),
                IsOk());
  }

  std::string Snapshot(double gain) const {
    return SerializeDeterministically(bundle::testing::RandomSnapshot(
        toy_.recipe, /*observation_width=*/68, /*action_width=*/4, gain));
  }
  std::unique_ptr<checkpoint::ArtifactStore> Store() const {
    return *checkpoint::OpenStore(JoinPath(run_, "checkpoints"),
                                  checkpoint::StoreAccess::kWrite,
                                  rpc::Security(), clock_);
  }
  void SaveState(const std::string& snapshot,
                 const std::string& assets = "") const {
    learner::Trainer::State state;
    state.counters.set_format_version(1);
    state.counters.set_iteration(12);
    state.counters.set_samples(345);
    state.counters.set_assets_sha256(assets);
    state.counters.mutable_metrics()->set_succeeded_starts(27);
    v1::SnapshotReference* reference = state.counters.add_snapshots();
    reference->set_version(12);
    reference->set_sha256(Sha256Hex(snapshot));
    state.snapshots.push_back(snapshot);
    ASSERT_THAT(learner::SaveState(*Store(), state, /*keep=*/2), IsOk());
  }
  void SaveBest(const std::string& snapshot,
                const std::string& assets = "") const {
    v1::EvaluatedPolicy evaluated;
    evaluated.set_iteration(9);
    evaluated.set_build("b9");
    evaluated.set_assets_sha256(assets);
    evaluated.mutable_metrics()->set_succeeded_starts(31);
    v1::Artifact record;
    record.set_id("policy-00000009");
    record.set_kind("policy");
    const auto store = Store();
    ASSERT_THAT(
        PutFiles(*store, record,
                 {{"snapshot", std::make_shared<const std::string>(snapshot)},
                  {"evaluated.pb", std::make_shared<const std::string>(
                                       evaluated.SerializeAsString())}}),
        IsOk());
    ASSERT_THAT(store->SetAlias("best", record.id()), IsOk());
  }
  absl::Status Run(const std::string& flags,
                   const std::string& run = "") const {
    CLI::App app;
    app.require_subcommand(1);
    Action action;
    AddExportCommand(app, action);
    app.parse(absl::StrCat("export --run ", run.empty() ? run_ : run, flags));
    return action(StopToken());
  }
  absl::Status Export(const std::string& flags = "",
                      const std::string& run = "") const {
    return Run(absl::StrCat(" --out ", Out(), flags), run);
  }
  std::string Out() const { return JoinPath(toy_.folder, "exported"); }

  const SystemClock clock_;
  const world::testing::ToyWorld toy_;
  const std::string run_;
};

TEST_F(ExportCommand, MakesABundleOfTheNewestState) {
  SaveState(Snapshot(0.2));
  SaveBest(Snapshot(0.4));

  ASSERT_THAT(Export(), IsOk());

  const auto bundle = bundle::ReadBundle(Out());
  ASSERT_THAT(bundle, IsOk());
  const v1::BundleProvenance& provenance = bundle->manifest.provenance();
  EXPECT_EQ(provenance.snapshot_sha256(), Sha256Hex(Snapshot(0.2)));
  EXPECT_EQ(provenance.iterations(), 12);
  EXPECT_EQ(provenance.samples(), 345);
  EXPECT_EQ(bundle->manifest.metrics().succeeded_starts(), 27);
}

TEST_F(ExportCommand, MakesABundleOfTheBestPolicyWithItsMetrics) {
  SaveState(Snapshot(0.2));
  SaveBest(Snapshot(0.4));

  ASSERT_THAT(Export(" --best"), IsOk());

  const auto bundle = bundle::ReadBundle(Out());
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.provenance().snapshot_sha256(),
            Sha256Hex(Snapshot(0.4)));
  EXPECT_EQ(bundle->manifest.provenance().iterations(), 9);
  EXPECT_EQ(bundle->manifest.provenance().build(), "b9");
  EXPECT_EQ(bundle->manifest.metrics().succeeded_starts(), 31);
}

TEST_F(ExportCommand, RefusesTheBestPolicyOfAnotherLibrary) {
  SaveState(Snapshot(0.2), "new assets");
  SaveBest(Snapshot(0.4), "old assets");

  EXPECT_THAT(Export(" --best"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected one of the run's assets new assets, "
                                 "found one of old assets")));
  EXPECT_FALSE(FileExists(Out()));
  EXPECT_THAT(Export(), IsOk());
}

TEST_F(ExportCommand, RefusesAStateOfBeforeTheLibraryChanged) {
  SaveState(Snapshot(0.2), "old assets");
  SaveBest(Snapshot(0.4), "old assets");
  SaveInputs({}, "new assets");

  for (const char* flags : {"", " --best"}) {
    EXPECT_THAT(
        Export(flags),
        StatusIs(absl::StatusCode::kFailedPrecondition,
                 HasSubstr("expected one of the run's assets new assets, "
                           "found one of old assets")));
    EXPECT_FALSE(FileExists(Out()));
  }
  SaveInputs({}, "old assets");
  EXPECT_THAT(Export(), IsOk());
}

TEST_F(ExportCommand, MakesABundleOfTheStageThatAProcedureCameTo) {
  SaveState(Snapshot(0.2));
  // The run becomes the only stage of a procedure.
  const std::string procedure = JoinPath(toy_.folder, "procedure");
  ASSERT_THAT(MakeDirectories(JoinPath(procedure, "stages")), IsOk());
  ProcedureRecord record;
  record.stages.emplace_back();
  record.stages[0].directory = "stages/00_primitive_0";
  record.stages[0].decision.next = learner::Stage();
  std::filesystem::rename(run_,
                          JoinPath(procedure, record.stages[0].directory));
  const std::string file = JoinPath(procedure, "procedure.json");
  ASSERT_THAT(WriteFileAtomically(file, PrintProcedure(record)), IsOk());

  EXPECT_THAT(
      Export("", procedure),
      StatusIs(
          absl::StatusCode::kFailedPrecondition,
          HasSubstr("--run " + JoinPath(procedure, "stages/00_primitive_0"))));
  EXPECT_FALSE(FileExists(Out()));
  record.stages[0].finished = learner::FinishedStage();
  record.end = learner::Decision();
  ASSERT_THAT(WriteFileAtomically(file, PrintProcedure(record)), IsOk());
  ASSERT_THAT(Export("", procedure), IsOk());

  const auto bundle = bundle::ReadBundle(Out());
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.provenance().snapshot_sha256(),
            Sha256Hex(Snapshot(0.2)));
}

TEST_F(ExportCommand, WritesAStateThatSaysWhatItsRunLearnsFrom) {
  v1::RunInputs::Source teacher;
  teacher.mutable_bundle()->set_role("teacher");
  teacher.mutable_bundle()->set_manifest_sha256("expert");
  SaveInputs({teacher}, "");
  v1::TaskAssets list;
  v1::Asset& library = *list.add_assets();
  library.set_role("library");
  library.set_sha256(toy_.library->digest());
  const auto assets =
      std::make_shared<const std::string>(list.SerializeAsString());
  SaveState(Snapshot(0.2), Sha256Hex(*assets));
  ASSERT_THAT(Store()->PutBlob(assets), IsOk());

  ASSERT_THAT(Run(" --state " + Out()), IsOk());

  const auto state = ReadCompactState(Out(), clock_);
  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->state.counters.iteration(), 12);
  ASSERT_TRUE(state->sources.has_value());
  EXPECT_THAT(*state->sources, ElementsAre(EqualsProto(teacher)));
}

// The run's states, moved to where a service has them.
class ExportCommandElsewhere : public ExportCommand {
 protected:
  void Serve() {
    const std::string elsewhere = JoinPath(toy_.folder, "elsewhere");
    std::filesystem::rename(JoinPath(run_, "checkpoints"), elsewhere);
    auto server = checkpoint::CheckpointServer::Start(
        {.address = sockets_.Address("s"), .folder = elsewhere}, clock_);
    ASSERT_THAT(server, IsOk());
    server_ = *std::move(server);
  }
  std::string Checkpoint() const {
    return absl::StrCat(" --checkpoint ", server_->address());
  }

  const rpc::SocketFolder sockets_;
  std::unique_ptr<checkpoint::CheckpointServer> server_;
};

TEST_F(ExportCommandElsewhere, MakesBundlesOfWhatAServiceHas) {
  SaveState(Snapshot(0.2));
  SaveBest(Snapshot(0.4));
  Serve();

  EXPECT_THAT(Export(),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("found no checkpoints/ (of a learner with "
                                 "--checkpoint they are there")));
  for (const auto& [flags, snapshot] :
       {std::pair("", Snapshot(0.2)), std::pair(" --best", Snapshot(0.4))}) {
    ASSERT_THAT(Export(absl::StrCat(flags, Checkpoint())), IsOk()) << flags;

    const auto bundle = bundle::ReadBundle(Out());
    ASSERT_THAT(bundle, IsOk());
    EXPECT_EQ(bundle->manifest.provenance().snapshot_sha256(),
              Sha256Hex(snapshot));
    ASSERT_THAT(RemoveRecursively(Out()), IsOk());
  }
}

TEST_F(ExportCommandElsewhere, WritesTheStateThatAServiceHas) {
  const auto assets =
      std::make_shared<const std::string>(v1::TaskAssets().SerializeAsString());
  SaveInputs({}, Sha256Hex(*assets));
  SaveState(Snapshot(0.2), Sha256Hex(*assets));
  ASSERT_THAT(Store()->PutBlob(assets), IsOk());
  Serve();

  ASSERT_THAT(Run(absl::StrCat(" --state ", Out(), Checkpoint())), IsOk());

  const auto state = ReadCompactState(Out(), clock_);
  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->state.counters.iteration(), 12);
}

TEST_F(ExportCommandElsewhere, RefusesAStoreOfAnotherRun) {
  SaveInputs({}, "own assets");
  SaveState(Snapshot(0.2), "other assets");
  Serve();

  for (const char* what : {" --out ", " --state "}) {
    EXPECT_THAT(Run(absl::StrCat(what, Out(), Checkpoint())),
                StatusIs(absl::StatusCode::kFailedPrecondition,
                         HasSubstr("expected one of the run's assets own "
                                   "assets, found one of other assets")));
    EXPECT_FALSE(FileExists(Out()));
  }
}

TEST_F(ExportCommandElsewhere, NamesAStoreThatHasNothingOfTheRun) {
  Serve();

  EXPECT_THAT(Export(Checkpoint()), StatusIs(absl::StatusCode::kNotFound,
                                             HasSubstr(server_->address())));
}

TEST_F(ExportCommand, WritesABundleOrAState) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

  EXPECT_THAT(Run(""), StatusIs(kInvalid, HasSubstr("found none")));
  EXPECT_THAT(Run(" --out a --state b"),
              StatusIs(kInvalid, HasSubstr("found both")));
  EXPECT_THAT(Run(" --state b --best"),
              StatusIs(kInvalid, HasSubstr("--best")));
}

TEST_F(ExportCommand, NamesWhatIsMissing) {
  EXPECT_THAT(Export(), StatusIs(absl::StatusCode::kNotFound));
  SaveState(Snapshot(0.2));
  EXPECT_THAT(Export(" --best"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("best")));
  ASSERT_THAT(RemoveRecursively(JoinPath(run_, "checkpoints")), IsOk());
  EXPECT_THAT(Export(), StatusIs(absl::StatusCode::kNotFound,
                                 HasSubstr("found no checkpoints/")));
  EXPECT_FALSE(FileExists(Out()));
}

}  // namespace
}  // namespace sinew::tools
