#include "tools/sinew/curriculum_command.h"

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/temporary_folder.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/training_state.pb.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::RunCommand;
using Json = nlohmann::json;

// A run directory as training leaves it, without the training.
class CurriculumCommand : public ::testing::Test {
 protected:
  CurriculumCommand() : folder_(*TemporaryFolder::Create()) {}

  std::string Run() const { return folder_->path(); }

  void WriteConfig(const std::string& only_clip = "") const {
    v1::Recipe recipe;
    if (!only_clip.empty()) {
      recipe.mutable_task()->mutable_start()->add_only_clips(only_clip);
    }
    recipe.mutable_task()->mutable_start()->set_rule(
        v1::Start::RULE_ADAPTIVE_BINS);
    ASSERT_THAT(WriteFileAtomically(JoinPath(Run(), "config.textproto"),
                                    PrintRecipe(WithDefaults(recipe))),
                IsOk());
    ASSERT_THAT(MakeDirectories(JoinPath(Run(), "checkpoints")), IsOk());
  }

  // Clips "walk" of two bins, "flip" of one, and "run", which is left out.
  static v1::TrainingState State(int64_t iteration) {
    v1::TrainingState state;
    state.set_iteration(iteration);
    state.set_samples(100 * iteration);
    v1::CurriculumTable& table = *state.mutable_curriculum();
    table.set_bin_frames(30);
    for (int b = 0; b < 3; ++b) {
      auto& bin = *table.add_bins();
      bin.set_clip(b / 2);
      bin.set_first_frame(30 * (b % 2));
      bin.set_num_frames(30);
      bin.set_probability(b == 2 ? 0.5 : 0.25);
      bin.set_visits(10 + b);
      bin.set_failures(b);
      bin.set_last_seen(b == 0 ? -1 : 7);
      bin.set_mean_body_distance(0.01 * (b + 1));
      bin.set_recent_passages(8);
      bin.set_recent_failures(4 * b);  // rates 0.1, 0.5, 0.9
    }
    for (const char* name : {"walk", "flip", "run"}) {
      auto& clip = *table.add_clips();
      clip.set_name(name);
      clip.set_evaluations(4);
      clip.set_succeeded_share(1);
    }
    table.mutable_clips(1)->set_failed_evaluations(3);
    table.mutable_clips(1)->set_failed_latest(true);
    table.mutable_clips(1)->set_succeeded_share(0.25);
    table.mutable_clips(1)->set_mean_error_mm(81);
    table.mutable_clips(2)->set_left_out(true);
    return state;
  }

  void SaveState(int64_t iteration, const std::string& file = "state.pb",
                 const std::string& recipe_sha256 = "") const {
    v1::TrainingState state = State(iteration);
    state.set_recipe_sha256(recipe_sha256);
    const auto store = checkpoint::OpenStore(JoinPath(Run(), "checkpoints"),
                                             checkpoint::StoreAccess::kWrite,
                                             rpc::Security(), clock_);
    ASSERT_THAT(store, IsOk());
    v1::Artifact record;
    record.set_id(absl::StrCat("state-", iteration));
    record.set_kind("state");
    ASSERT_THAT(PutFiles(**store, record,
                         {{file, std::make_shared<const std::string>(
                                     state.SerializeAsString())}}),
                IsOk());
    ASSERT_THAT((*store)->SetAlias("latest", record.id()), IsOk());
  }

  // What the command prints.
  absl::StatusOr<std::string> Output(const std::string& flags = "") const {
    std::string output;
    const absl::Status status = RunCommand(
        AddCurriculumCommand, absl::StrCat("curriculum ", Run(), flags),
        /*stop=*/{}, &output);
    if (!status.ok()) return status;
    return output;
  }

  const SystemClock clock_;
  const std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(CurriculumCommand, ReadsStatesThatAreKeptElsewhere) {
  WriteConfig();
  SaveState(4);
  const std::string elsewhere = JoinPath(folder_->path(), "elsewhere");
  std::filesystem::rename(JoinPath(Run(), "checkpoints"), elsewhere);

  EXPECT_THAT(Output(),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("found no checkpoints/ (of a learner with "
                                 "--checkpoint they are there)")));
  const auto output = Output(absl::StrCat(" --json --checkpoint ", elsewhere));

  ASSERT_THAT(output, IsOk());
  EXPECT_EQ(Json::parse(*output)["iteration"], 4);
}

TEST_F(CurriculumCommand, NamesAStoreThatHasNothingOfTheRun) {
  WriteConfig();
  const std::string empty = JoinPath(folder_->path(), "empty");
  ASSERT_THAT(MakeDirectories(empty), IsOk());

  EXPECT_THAT(Output(absl::StrCat(" --checkpoint ", empty)),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr(absl::StrCat("a training state in ", empty))));
}

TEST_F(CurriculumCommand, RefusesStatesOfAnotherRecipe) {
  WriteConfig();
  SaveState(4, "state.pb", "0123");

  EXPECT_THAT(Output(), StatusIs(absl::StatusCode::kFailedPrecondition,
                                 AllOf(HasSubstr("config.textproto"),
                                       HasSubstr("another run's (0123)"))));
}

TEST_F(CurriculumCommand, ShowsTheTableOfTheNewestState) {
  WriteConfig();
  SaveState(4);
  SaveState(8);

  const auto output = Output(" --json");

  ASSERT_THAT(output, IsOk());
  const Json json = Json::parse(*output);
  EXPECT_EQ(json["iteration"], 8);
  EXPECT_EQ(json["samples"], 800);
  EXPECT_EQ(json["rule"], "adaptive_bins");
  EXPECT_EQ(json["summary"]["clips"], 2);
  EXPECT_EQ(json["summary"]["left_out_clips"], 1);
  EXPECT_EQ(json["summary"]["hard_clips"], 1);
  EXPECT_EQ(json["summary"]["worst_success"], 0.25);
  EXPECT_GT(json["summary"]["floor_share"], 0.09);
  ASSERT_EQ(json["clips"].size(), 2u);
  EXPECT_EQ(json["clips"][0]["name"], "flip");
  EXPECT_EQ(json["clips"][0]["failed_evaluations"], 3);
  EXPECT_EQ(json["clips"][1]["visits"], 21);
  EXPECT_EQ(json["clips"][1]["last_seen"], 7);
  // 10 episodes at 10 mm and 11 at 20.
  EXPECT_NEAR(json["clips"][1]["tracking_error_mm"].get<double>(), 320. / 21,
              1e-9);
  EXPECT_NEAR(json["bins"][1]["tracking_error_mm"].get<double>(), 20, 1e-9);
  ASSERT_EQ(json["bins"].size(), 3u);
  EXPECT_EQ(json["bins"][1]["clip"], "walk");
  EXPECT_EQ(json["bins"][1]["from_s"], 1.0);
  EXPECT_EQ(json["bins"][1]["to_s"], 2.0);
  EXPECT_EQ(json["left_out"][0]["name"], "run");
}

TEST_F(CurriculumCommand, PrintsAPathThatIsNoText) {
  WriteConfig();
  SaveState(4);
  const std::string strange = Run() + "\xff";
  std::filesystem::create_directory_symlink(Run(), strange);
  const absl::Cleanup remove = [&] { std::filesystem::remove(strange); };
  std::string output;

  ASSERT_THAT(
      RunCommand(AddCurriculumCommand, "curriculum " + strange + " --json",
                 /*stop=*/{}, &output),
      IsOk());

  EXPECT_EQ(Json::parse(output)["iteration"], 4);
}

TEST_F(CurriculumCommand, ListsAsManyAsWereAskedFor) {
  WriteConfig();
  SaveState(4);

  const auto output = Output(" --json --hardest 1");

  ASSERT_THAT(output, IsOk());
  const Json json = Json::parse(*output);
  EXPECT_EQ(json["clips"].size(), 1u);
  ASSERT_EQ(json["bins"].size(), 1u);
  EXPECT_EQ(json["bins"][0]["clip"], "flip");
}

TEST_F(CurriculumCommand, SaysItInWords) {
  WriteConfig();
  SaveState(4);

  const auto output = Output();

  ASSERT_THAT(output, IsOk());
  EXPECT_THAT(*output, HasSubstr("iteration 4: rule adaptive_bins, 2 clips (1 "
                                 "more left out), 3 bins"));
  EXPECT_THAT(*output, HasSubstr("2 clips evaluated, 1 failed the latest time; "
                                 "worst tenth: 25 % of starts"));
  EXPECT_THAT(*output,
              HasSubstr("3 of 4 failed; latest: 25 % of starts, 81 mm"));
  EXPECT_THAT(*output, HasSubstr("hardest bins"));
  EXPECT_THAT(*output, HasSubstr("left out of training"));
}

TEST_F(CurriculumCommand, SaysHowManyClipsStartsAreDrawnFrom) {
  WriteConfig("walk");
  SaveState(4);

  const auto text = Output();
  const auto output = Output(" --json");

  ASSERT_THAT(text, IsOk());
  EXPECT_THAT(*text, HasSubstr("2 clips (1 more left out), starts from 1 of "
                               "them, 2 bins"));
  EXPECT_THAT(*text, HasSubstr("2 clips evaluated, 1 failed the latest time"));
  ASSERT_THAT(output, IsOk());
  const Json json = Json::parse(*output);
  EXPECT_EQ(json["summary"]["clips"], 2);
  EXPECT_EQ(json["summary"]["drawn_clips"], 1);
  ASSERT_EQ(json["clips"].size(), 1u);
  EXPECT_EQ(json["clips"][0]["name"], "walk");
  EXPECT_EQ(json["bins"].size(), 2u);
}

TEST_F(CurriculumCommand, ReadsWhileTheLearnerHoldsTheStore) {
  WriteConfig();
  SaveState(4);
  const auto writer = checkpoint::OpenStore(JoinPath(Run(), "checkpoints"),
                                            checkpoint::StoreAccess::kWrite,
                                            rpc::Security(), clock_);
  ASSERT_THAT(writer, IsOk());

  EXPECT_THAT(Output(), IsOk());
}

TEST_F(CurriculumCommand, SaysWhatIsNoRun) {
  EXPECT_THAT(Output(), StatusIs(absl::StatusCode::kNotFound,
                                 HasSubstr("expected a run directory, found no "
                                           "config.textproto")));
  WriteConfig();
  EXPECT_THAT(Output(), StatusIs(absl::StatusCode::kNotFound,
                                 HasSubstr("expected a training state in")));
  SaveState(4, "other.pb");
  EXPECT_THAT(
      Output(),
      StatusIs(absl::StatusCode::kDataLoss,
               HasSubstr("state-4: training state: expected a file state.pb")));
}

TEST_F(CurriculumCommand, PassesOverAStateThatIsDamaged) {
  WriteConfig();
  SaveState(4);
  SaveState(8, "other.pb");

  ::testing::internal::CaptureStderr();
  const auto output = Output(" --json");
  const std::string errors = ::testing::internal::GetCapturedStderr();

  ASSERT_THAT(output, IsOk());
  EXPECT_EQ(Json::parse(*output)["iteration"], 4);
  EXPECT_THAT(errors, HasSubstr("passed over state-8"));
}

}  // namespace
}  // namespace sinew::tools
