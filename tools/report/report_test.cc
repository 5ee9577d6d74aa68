#include "tools/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/check.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "proto/sinew/v1/training_state.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/report/core_seconds.h"
#include "tools/report/curves.h"
#include "tools/report/page.h"
#include "tools/report/page_data.h"
#include "tools/report/run_record.h"
#include "tools/report/testing/browser.h"

namespace sinew::report {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// Two seconds of two cores per iteration; an evaluation every fifth.
Json Row(int iteration) {
  Json row = {
      {"iteration", iteration},
      {"wall_s", 2.0 * iteration},
      {"train_s", 1.5 * iteration},
      {"samples", 1000 * iteration},
      {"reward", 0.5 + 0.01 * iteration},
      {"reward_terms", {0.1, 0.2, 0.3, 0.4}},
      {"body_distance_m", 0.05},
      {"episodes", 10},
      {"failed_episodes", 5},
      {"kl", 0.02},
      {"cores", 2},
      {"ranks", 2},
      {"seconds", {{"simulate", 1.5}, {"infer", 0.25}, {"learn", 0.5}}}};
  if (iteration % 5 == 0) {
    row["eval"] = {{"iteration", iteration},
                   {"starts", 32},
                   {"succeeded_starts", 8},
                   {"survived_share", 0.5},
                   {"e_g_mpjpe_mm", 60.0}};
  }
  return row;
}

std::vector<Json> Rows(int count) {
  std::vector<Json> rows;
  for (int i = 1; i <= count; ++i) rows.push_back(Row(i));
  return rows;
}

std::string NewFolder() {
  const std::string folder =
      JoinPath(::testing::TempDir(),
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
  SINEW_CHECK(RemoveRecursively(folder).ok());
  SINEW_CHECK(MakeDirectories(folder).ok());
  return folder;
}

void WriteRun(const std::string& folder) {
  std::string metrics;
  for (const Json& row : Rows(20)) absl::StrAppend(&metrics, row.dump(), "\n");
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.set_name("toy_recipe");
  SINEW_CHECK(
      WriteFileAtomically(JoinPath(folder, "metrics.jsonl"), metrics).ok());
  SINEW_CHECK(WriteFileAtomically(JoinPath(folder, "config.textproto"),
                                  PrintRecipe(recipe))
                  .ok());
}

TEST(Curves, AreMeansOverNeighbouringRows) {
  const Json curves = TrainingCurves(Rows(3 * kMaxPoints));

  ASSERT_THAT(curves["reward"], SizeIs(kMaxPoints));
  EXPECT_EQ(curves["iteration"][0], 3);  // the last of three
  EXPECT_DOUBLE_EQ(curves["reward"][0].get<double>(), 0.52);
  EXPECT_DOUBLE_EQ(curves["tracking_mm"][0].get<double>(), 50);
  EXPECT_DOUBLE_EQ(curves["fail_share"][0].get<double>(), 0.5);
  EXPECT_DOUBLE_EQ(curves["reward_linear"][0].get<double>(), 0.3);
  // 3000 samples in 6 s.
  EXPECT_DOUBLE_EQ(curves["samples_per_s"][1].get<double>(), 500);
}

TEST(Curves, LeaveOutWhatNoRowHas) {
  std::vector<Json> rows = Rows(3);
  rows[1].erase("kl");
  rows[1]["reward"] = "not a number";

  const Json curves = TrainingCurves(rows);

  EXPECT_FALSE(curves.contains("clip_fraction"));
  EXPECT_TRUE(curves["kl"][1].is_null());
  EXPECT_TRUE(curves["reward"][1].is_null());
  EXPECT_EQ(TrainingCurves({}), Json::object());
}

TEST(Curves, HoldEveryEvaluation) {
  const Json curves = EvaluationCurves(Rows(20));

  EXPECT_EQ(curves["iteration"], Json({5, 10, 15, 20}));
  EXPECT_EQ(curves["succeeded_share"], Json({0.25, 0.25, 0.25, 0.25}));
  EXPECT_FALSE(curves.contains("e_acc"));
  EXPECT_FALSE(curves.contains("left_out_succeeded_share"));
}

TEST(Curves, HoldWhatIsLeftOutOfTraining) {
  std::vector<Json> rows = Rows(5);
  rows[4]["eval"]["left_out"] = {{"starts", 4}, {"succeeded_starts", 3}};

  const Json curves = EvaluationCurves(rows);

  ASSERT_THAT(curves["left_out_succeeded_share"], SizeIs(1));
  EXPECT_EQ(curves["left_out_succeeded_share"][0], 0.75);
}

// Rows of a run over 8 bins, evaluated from the third row on.
std::vector<Json> RowsWithCurriculum(int count) {
  std::vector<Json> rows = Rows(count);
  for (int i = 0; i < count; ++i) {
    rows[i]["curriculum"] = {{"clips", 4},
                             {"bins", 8},
                             {"entropy_share", 0.9},
                             {"floor_share", 0.1},
                             {"hardest_share", 0.25},
                             {"evaluated_clips", i < 2 ? 0 : 4},
                             {"hard_clips", i < 2 ? 0 : 1},
                             {"worst_success", i < 2 ? 0 : 0.5}};
  }
  return rows;
}

TEST(Curves, OfTheCurriculumAreThereWhereItHasMoreThanOneBin) {
  const Json curves = CurriculumCurves(RowsWithCurriculum(5));

  ASSERT_THAT(curves["entropy_share"], SizeIs(5));
  EXPECT_EQ(curves["train_s"][4], 7.5);
  EXPECT_DOUBLE_EQ(curves["hardest_share"][0].get<double>(), 0.25);
  EXPECT_TRUE(curves["worst_success"][1].is_null());
  EXPECT_DOUBLE_EQ(curves["worst_success"][2].get<double>(), 0.5);
  EXPECT_FALSE(curves.contains("clips_of_half"));

  std::vector<Json> single = RowsWithCurriculum(2);
  for (Json& row : single) row["curriculum"]["bins"] = 1;
  EXPECT_TRUE(CurriculumCurves(single).empty());
  EXPECT_TRUE(CurriculumCurves(Rows(2)).empty());
  EXPECT_TRUE(CurriculumCurves({}).empty());
}

TEST(PageData, HasTheCurriculumOfARunOfManyBins) {
  RunRecord run;
  run.rows = RowsWithCurriculum(3);
  PageContext context;
  context.curriculum = {{"rule", "adaptive_bins"}};

  const Json curriculum = MakePageData(run, context)["curriculum"];
  EXPECT_EQ(curriculum["rule"], "adaptive_bins");
  EXPECT_THAT(curriculum["curves"]["entropy_share"], SizeIs(3));

  run.rows = Rows(3);
  EXPECT_TRUE(MakePageData(run, context)["curriculum"].is_null());
}

TEST(CoreSeconds, AddUpToCoresTimesWallTime) {
  const CoreSeconds counted = CountCoreSeconds(Rows(10));

  // 2 cores x 20 s; learning is 10 x 0.5 s on 2 ranks; the rest is idle.
  EXPECT_DOUBLE_EQ(counted.total, 40);
  std::map<std::string, double> seconds;
  for (const Stage& stage : counted.stages) seconds[stage.name] = stage.seconds;
  EXPECT_DOUBLE_EQ(seconds["simulate"], 15);
  EXPECT_DOUBLE_EQ(seconds["infer"], 2.5);
  EXPECT_DOUBLE_EQ(seconds["learn"], 10);
  EXPECT_DOUBLE_EQ(seconds["wait"], 12.5);
  EXPECT_THAT(seconds, SizeIs(4));
}

TEST(CoreSeconds, HoldAllCoresWhileLabelsAreWaitedFor) {
  std::vector<Json> rows = Rows(10);
  for (Json& row : rows) row["seconds"]["label"] = 0.25;

  const CoreSeconds counted = CountCoreSeconds(rows);

  // 10 x 0.25 s of wall time on 2 cores, less of "wait".
  std::map<std::string, double> seconds;
  for (const Stage& stage : counted.stages) seconds[stage.name] = stage.seconds;
  EXPECT_DOUBLE_EQ(seconds["label"], 5);
  EXPECT_DOUBLE_EQ(seconds["wait"], 7.5);
  EXPECT_DOUBLE_EQ(counted.total, 40);
}

TEST(CoreSeconds, GuessTheCoresOfRowsThatDoNotSay) {
  std::vector<Json> rows = Rows(10);
  for (Json& row : rows) {
    row.erase("cores");
    row.erase("ranks");
    row["seconds"]["wait"] = 0.9;  // 1.75 busy seconds meanwhile
  }

  EXPECT_DOUBLE_EQ(CountCoreSeconds(rows).cores, 2);
  EXPECT_DOUBLE_EQ(CountCoreSeconds({}).total, 0);
}

TEST(Runs, AreReadWhateverIsDamaged) {
  const std::string folder = NewFolder();
  WriteRun(folder);
  ASSERT_THAT(AppendToFile(JoinPath(folder, "metrics.jsonl"), "{\"iter"),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "eval.json"), "[1"), IsOk());

  const auto run = ReadRun(folder);

  ASSERT_THAT(run, IsOk());
  EXPECT_THAT(run->rows, SizeIs(20));
  EXPECT_TRUE(run->evaluation.is_null());
  EXPECT_THAT(run->notes,
              ElementsAre(HasSubstr("1 lines are no JSON objects (first: line "
                                    "21)"),
                          HasSubstr("eval.json: expected a JSON object"),
                          HasSubstr("no bundle")));
}

TEST(Runs, AreRefusedWhereThereIsNone) {
  EXPECT_THAT(ReadRun(NewFolder()),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("expected a run directory")));
}

TEST(PageData, TakesTheResultFromTheEvaluationElseFromTraining) {
  RunRecord run;
  run.directory = "runs/it";
  run.rows = Rows(10);

  Json head = MakePageData(run, {})["headline"];
  EXPECT_EQ(head["source"], "training");
  EXPECT_EQ(head["succeeded_starts"], 8);
  EXPECT_DOUBLE_EQ(head["minutes"].get<double>(), 0.25);

  run.evaluation = {{"overall", {{"starts", 32}, {"succeeded_starts", 31}}},
                    {"zero_action", {{"succeeded_starts", 1}}},
                    {"seconds", 10}};
  head = MakePageData(run, {})["headline"];
  EXPECT_EQ(head["source"], "eval.json");
  EXPECT_EQ(head["succeeded_starts"], 31);
  EXPECT_EQ(head["zero_action"]["succeeded_starts"], 1);
}

TEST(PageData, HasCommandsThatAShellTakes) {
  RunRecord run;
  run.directory = "runs/my run";
  run.rows = Rows(10);
  PageContext context;
  context.motions = "it's";

  const Json commands = MakePageData(run, context)["reproduce"];

  EXPECT_EQ(commands[0],
            "./sinew train --recipe 'runs/my run/config.textproto' --motions "
            "'it'\\''s' --run runs/again --iterations 10");
}

TEST(Page, LetsNoDataActAsMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--";

  const std::string page = MakePage({{"title", hostile}});

  EXPECT_THAT(page, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script\\u003e"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

// --- In a browser ------------------------------------------------------------

// A browser for a page without WebGL.
std::string BrowsePage(const std::string& page, const std::string& folder,
                       std::vector<std::string> flags) {
  flags.push_back("--disable-gpu");
  flags.push_back("--virtual-time-budget=2000");
  return testing::Browse(page, folder, flags);
}

// Share of the pixels that differ from the picture's corner, and the number
// of colours.
struct Ink {
  double share = 0;
  size_t colours = 0;
};

Ink InkOf(const std::string& png) {
  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load(png.c_str(), &width, &height, &channels, 3);
  SINEW_CHECK(pixels != nullptr) << png;
  std::set<int> colours;
  int64_t ink = 0;
  const auto colour = [&](int64_t i) {
    return pixels[3 * i] << 16 | pixels[3 * i + 1] << 8 | pixels[3 * i + 2];
  };
  const int64_t count = int64_t{width} * height;
  for (int64_t i = 0; i < count; ++i) {
    colours.insert(colour(i));
    ink += colour(i) != colour(0) ? 1 : 0;
  }
  stbi_image_free(pixels);
  return {static_cast<double>(ink) / static_cast<double>(count),
          colours.size()};
}

size_t Count(const std::string& text, const std::string& what) {
  return std::vector<std::string>(absl::StrSplit(text, what)).size() - 1;
}

// A run that was trained, evaluated and exported, as far as files go.
class FinishedRun : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = NewFolder();
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    motions_ = JoinPath(toy.folder, "library");
    WriteRun(folder_);
    const std::string bundle = JoinPath(folder_, "bundle");
    ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
                IsOk());
    ASSERT_THAT(evaluation::EvaluateBundle(
                    bundle, motions_, JoinPath(folder_, "eval.json"),
                    {.starts = 2, .seconds = 1, .threads = 2}, StopToken()),
                IsOk());
  }

  std::string folder_, motions_;
};

TEST_F(FinishedRun, IsDrawnByARealBrowser) {
  const auto path = WriteReport({.run = folder_, .clip = "sway"}, StopToken());
  ASSERT_THAT(path, IsOkAndHolds(JoinPath(folder_, "report.html")));

  const std::string dom = BrowsePage(*path, folder_, {"--dump-dom"});

  EXPECT_THAT(dom, HasSubstr("3 clips · toy_recipe"));
  EXPECT_THAT(
      dom, AllOf(HasSubstr("of 6 starts"), HasSubstr("In motion"),
                 HasSubstr("Learning curves"), HasSubstr("tumble"),
                 HasSubstr("Where core-seconds went"),
                 HasSubstr("format_version: 1"), HasSubstr("./sinew train")));
  EXPECT_GE(Count(dom, "<svg"), 8u);             // curves and heat map
  EXPECT_GE(Count(dom, "data:image/jpeg"), 2u);  // sheet and strip
  EXPECT_THAT(dom, Not(HasSubstr("<h2>Where episodes start</h2>")));
  const std::string picture = JoinPath(folder_, "page.png");
  BrowsePage(
      *path, folder_,
      {absl::StrCat("--screenshot=", picture), "--window-size=1200,3000"});
  const Ink ink = InkOf(picture);
  EXPECT_GT(ink.share, 0.15);
  EXPECT_GT(ink.colours, 500u);
}

TEST_F(FinishedRun, ShowsTheCurriculumOfManyBins) {
  std::string metrics;
  for (const Json& row : RowsWithCurriculum(20)) {
    absl::StrAppend(&metrics, row.dump(), "\n");
  }
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder_, "metrics.jsonl"), metrics),
              IsOk());
  const SystemClock clock;
  const auto store = checkpoint::OpenStore(JoinPath(folder_, "checkpoints"),
                                           checkpoint::StoreAccess::kWrite,
                                           rpc::Security(), clock);
  ASSERT_THAT(store, IsOk());
  v1::TrainingState state;
  v1::CurriculumTable& table = *state.mutable_curriculum();
  for (int c = 0; c < 2; ++c) {
    auto& bin = *table.add_bins();
    bin.set_clip(c);
    bin.set_num_frames(30);
    bin.set_probability(0.5);
    bin.set_last_seen(-1);
    table.add_clips()->set_name(c == 0 ? "stroll" : "cartwheel");
  }
  v1::Artifact record;
  record.set_id("state-20");
  record.set_kind("state");
  ASSERT_THAT(PutFiles(**store, record,
                       {{"state.pb", std::make_shared<const std::string>(
                                         state.SerializeAsString())}}),
              IsOk());
  ASSERT_THAT((*store)->SetAlias("latest", record.id()), IsOk());

  const auto path = WriteReport({.run = folder_, .clip = "sway"}, StopToken());
  ASSERT_THAT(path, IsOk());

  const std::string dom = BrowsePage(*path, folder_, {"--dump-dom"});
  EXPECT_THAT(dom,
              AllOf(HasSubstr("<h2>Where episodes start</h2>"),
                    HasSubstr("<h3>How wide the starts are spread</h3>"),
                    HasSubstr(">cartwheel</td>"), HasSubstr(">never</td>")));
}

TEST_F(FinishedRun, IsReportedWithoutItsLibraryToo) {
  ASSERT_THAT(RemoveRecursively(motions_), IsOk());

  const auto path = WriteReport({.run = folder_}, StopToken());

  ASSERT_THAT(path, IsOk());
  EXPECT_THAT(*ReadFile(*path), AllOf(HasSubstr(motions_), HasSubstr("turn")));
}

TEST_F(FinishedRun, NamesAClipThatIsNotThere) {
  EXPECT_THAT(WriteReport({.run = folder_, .clip = "walk"}, StopToken()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("\"walk\"")));
  EXPECT_FALSE(FileExists(JoinPath(folder_, "report.html")));
}

TEST(Report, OfARunThatIsNotThereIsRefused) {
  EXPECT_THAT(
      WriteReport({.run = NewFolder()}, StopToken()),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("run directory")));
}

}  // namespace
}  // namespace sinew::report
