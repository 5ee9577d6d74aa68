#include "tools/sampling/shown_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"
#include "tools/report/testing/browser.h"
#include "tools/sampling/library_transitions.h"
#include "tools/sampling/sample_figures.h"
#include "tools/sampling/sampling_json.h"

namespace sinew::sampling {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// `frames` of the toy standing `x` m ahead.
ShownWay::Sample Standing(const world::testing::ToyWorld& toy, double x,
                          int frames) {
  const mjModel* model = toy.character->model();
  std::vector<double> qpos(model->qpos0, model->qpos0 + model->nq);
  qpos[0] = x;
  qpos[2] = toy.character->proto().standing_root_height();
  ShownWay::Sample sample = {.start = "here", .qpos = {}};
  for (int i = 0; i < frames; ++i) {
    sample.qpos.insert(sample.qpos.end(), qpos.begin(), qpos.end());
  }
  return sample;
}

SampleFigures Figures(const std::string& name, int samples) {
  SampleFigures figures;
  figures.name = name;
  figures.samples = samples;
  figures.upright_share = 0.5;
  return figures;
}

SamplingSource Source() {
  SamplingSource source;
  source.bundle = "runs/<toy>";
  source.character = "toy";
  source.start = "clip";
  source.seconds = 1;
  source.seed = 5;
  source.control_hz = 30;
  return source;
}

TEST(SamplesPage, IsPlayedByARealBrowser) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const ShownWay way = {.name = "noise 1",
                        .samples = {Standing(toy, 0, 12), Standing(toy, 1, 30),
                                    Standing(toy, 2, 20)}};

  const auto page =
      SamplesPage(*toy.character, Source(),
                  {Figures("zero action", 2), Figures("noise 1", 7)}, {way});

  ASSERT_THAT(page, IsOk());
  const std::string path = JoinPath(toy.folder, "samples.html");
  ASSERT_THAT(WriteFileAtomically(path, *page), IsOk());
  const std::string dom = report::testing::Browse(
      path, toy.folder,
      {"--use-angle=swiftshader", "--enable-unsafe-swiftshader",
       "--virtual-time-budget=1500", "--dump-dom"});
  EXPECT_THAT(dom, AllOf(HasSubstr("3 of 7 samples"), HasSubstr("seed 5."),
                         HasSubstr("<h1>runs/&lt;toy&gt;</h1>"),
                         HasSubstr("<td>50.0</td>"),
                         // As long as the longest, not as the first.
                         HasSubstr("max=\"29\""),
                         Not(HasSubstr("which the viewer draws with.</"))));
}

TEST(SamplesPage, RefusesASampleWithoutFrames) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const ShownWay way = {.name = "noise 1",
                        .samples = {Standing(toy, 0, /*frames=*/0)}};

  EXPECT_THAT(
      SamplesPage(*toy.character, Source(), {Figures("noise 1", 1)}, {way})
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("body_position")));
}

TEST(WritePictures, DrawsAStripOfEverySample) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string folder = JoinPath(toy.folder, "pictures");

  const auto paths =
      WritePictures(*toy.character, 30,
                    {{.name = "noise 0.5",
                      .samples = {Standing(toy, 0, 9), Standing(toy, 1, 9)}}},
                    folder, StopToken());

  ASSERT_THAT(paths, IsOk());
  EXPECT_THAT(*paths, ElementsAre(JoinPath(folder, "noise_0.5-0.png"),
                                  JoinPath(folder, "noise_0.5-1.png")));
  EXPECT_THAT(*ReadFile(paths->front()), HasSubstr("PNG"));
}

TEST(SamplingJson, HasNoFootSkateWhereNoFootTouchedTheFloor) {
  SampleFigures figures = Figures("noise 1", 1);
  figures.rows.emplace_back();
  const LibraryTransitions library;

  // Of the way, of its sample and of the library.
  const std::vector<std::string> lines =
      absl::StrSplit(SamplingJson(Source(), &library, {figures}), '\n');
  EXPECT_THAT(lines, Contains(AllOf(HasSubstr("\"foot_skate_m_per_s\""),
                                    HasSubstr(": null")))
                         .Times(3));
}

TEST(SamplingTable, HasALinePerWayAndNoFigureOfNothing) {
  const std::string table =
      SamplingTable({Figures("zero action", 2), Figures("noise 1", 8)});

  EXPECT_THAT(
      table, AllOf(HasSubstr("upright %"), HasSubstr("zero action"),
                   HasSubstr("50.0"), HasSubstr(" - "), Not(HasSubstr("nan"))));
}

}  // namespace
}  // namespace sinew::sampling
