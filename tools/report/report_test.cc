// Reports in a real browser: their documents and their pictures.

#include "tools/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/check.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"
#include "proto/sinew/v1/training_state.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/report/testing/browser.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
    folder_ = TestPath("run");
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    motions_ = JoinPath(toy.folder, "library");
    testing::WriteRun(folder_);
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
  ASSERT_THAT(WriteFileAtomically(
                  JoinPath(folder_, "metrics.jsonl"),
                  testing::MetricsText(testing::RowsWithCurriculum(20))),
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
  const std::string folder = TestPath("empty");
  ASSERT_THAT(MakeDirectories(folder), IsOk());

  EXPECT_THAT(
      WriteReport({.run = folder}, StopToken()),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("run directory")));
}

}  // namespace
}  // namespace sinew::report
