#include "tools/sampling/sample_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/stop.h"
#include "sim/metrics/transitions.h"
#include "sim/world/body_state.h"
#include "tools/sampling/library_transitions.h"
#include "tools/sampling/sample_starts.h"
#include "tools/sampling/sampler.h"
#include "tools/sampling/testing/toy_sampler.h"

namespace sinew::sampling {
namespace {

using ::testing::SizeIs;

struct Toy : testing::ToySampler {
  SampleFigures Measure(const std::vector<SampleStart>& starts,
                        const std::vector<SampleMotion>& motions,
                        const LibraryTransitions* library = nullptr,
                        const FigureOptions& options = {}) const {
    return MeasureSamples(*sampler, starts, motions, library, options,
                          StopToken())
        .value();
  }
  LibraryTransitions Transitions(int64_t most = 1000) const {
    return MakeLibraryTransitions(*sampler, *world.library, most, StopToken())
        .value();
  }
};

// Of the toy, which stands 0.44 m high; upright from 0.264 m on.
SampleMotion Motion(int start, double first_height, double last_height) {
  SampleMotion motion;
  motion.start = start;
  motion.upright_height = {first_height, last_height};
  motion.path.root = {1, 2, 4, 6};
  motion.path.points = {0, 0, 0, 0, 0, 0};
  return motion;
}

// A motion that does what a clip does, from its first frame on.
SampleMotion Playback(const Toy& toy, int clip, int frames) {
  const Sampler& sampler = *toy.sampler;
  world::BodyState state(sampler.law().num_bodies(),
                         sampler.law().num_joints());
  SampleMotion motion;
  for (int i = 0; i < frames; ++i) {
    sampler.law().reader().Read(toy.world.library->frame(clip, i), &state);
    sampler.AppendFeatures(state, motion.states);
    motion.upright_height.push_back(0.44);
    motion.path.root.insert(motion.path.root.end(), {0, 0});
    motion.path.points.insert(motion.path.points.end(), {0, 0, 0});
  }
  return motion;
}

TEST(MeasureSamples, CountsWhoStaysUprightAndWhoGetsUp) {
  const Toy toy;
  std::vector<SampleMotion> motions = {
      Motion(0, 0.44, 0.44), Motion(0, 0.44, 0.27), Motion(0, 0.44, 0.26),
      Motion(1, 0.1, 0.3),   Motion(1, 0.1, 0.1),   Motion(1, 0.1, 0.1)};
  // Up for a while, down again.
  motions.back().upright_height = {0.1, 0.3, 0.1};
  motions.push_back(Motion(1, 0.1, 0.1));
  motions.push_back(Motion(0, 0.44, 0.44));
  motions.back().diverged = true;

  const SampleFigures figures =
      toy.Measure({{.name = "a", .qpos = {}, .qvel = {}},
                   {.name = "b", .qpos = {}, .qvel = {}}},
                  motions);

  EXPECT_EQ(figures.samples, 8);
  EXPECT_EQ(figures.starts, 2);
  EXPECT_EQ(figures.diverged, 1);
  EXPECT_EQ(figures.began_upright, 4);
  EXPECT_DOUBLE_EQ(figures.upright_share, 0.5);  // not the diverged one
  EXPECT_DOUBLE_EQ(figures.got_up_share, 0.25);
  EXPECT_DOUBLE_EQ(figures.stuck_share, 0.5);
  ASSERT_THAT(figures.rows, SizeIs(8));
  EXPECT_EQ(figures.rows[3].start, "b");
  EXPECT_FALSE(figures.rows[3].began_upright);
  EXPECT_TRUE(figures.rows[3].upright);
  EXPECT_TRUE(figures.rows[5].ever_upright);
  EXPECT_FALSE(figures.rows[5].upright);
  EXPECT_DOUBLE_EQ(figures.rows[0].root_distance, 5);
  EXPECT_DOUBLE_EQ(figures.rows[0].seconds, 1.0 / 30);
  EXPECT_FALSE(figures.transitions.has_value());
}

TEST(MeasureSamples, HasNoShareOfNothing) {
  const Toy toy;

  const SampleFigures figures = toy.Measure(
      {{.name = "a", .qpos = {}, .qvel = {}}}, {Motion(0, 0.44, 0.44)});

  EXPECT_DOUBLE_EQ(figures.upright_share, 1);
  EXPECT_TRUE(std::isnan(figures.got_up_share));
  EXPECT_TRUE(std::isnan(figures.stuck_share));
  EXPECT_EQ(figures.diversity.pairs, 0);
  EXPECT_EQ(figures.latent.steps, 0);
  EXPECT_TRUE(std::isnan(figures.rows[0].foot_skate));
}

TEST(MeasureSamples, TellsHowFeetThatTouchTheFloorSlide) {
  const Toy toy;
  std::vector<SampleMotion> motions = {Motion(0, 0.44, 0.44)};
  motions[0].skate = {.contacts = 4, .sum_m_per_s = 1};

  const SampleFigures figures =
      toy.Measure({{.name = "a", .qpos = {}, .qvel = {}}}, motions);

  EXPECT_DOUBLE_EQ(figures.rows[0].foot_skate, 0.25);
}

TEST(MeasureSamples, AClipPlayedBackCoversItselfButForItsStart) {
  const Toy toy;
  const LibraryTransitions library = toy.Transitions();
  // Clip "sway": 20 frames, 19 transitions, the first of which is that of the
  // start; the library has 24 + 19 + 15.
  ASSERT_EQ(library.all, 58);
  ASSERT_EQ(library.rows.rows(), 58);

  const SampleFigures figures =
      toy.Measure({{.name = "a", .qpos = {}, .qvel = {}}},
                  {Playback(toy, /*clip=*/1, /*frames=*/20)}, &library,
                  {.threshold = 1e-3});

  ASSERT_TRUE(figures.transitions.has_value());
  EXPECT_EQ(figures.transitions->library, 58);
  EXPECT_EQ(figures.transitions->generated, 18);
  EXPECT_NEAR(figures.transitions->distance, 0, 1e-6);
  EXPECT_DOUBLE_EQ(figures.transitions->coverage, 18.0 / 58);
  EXPECT_EQ(figures.transitions->far_share, 0);
  ASSERT_THAT(figures.coverage_curve, SizeIs(5));
  for (size_t i = 1; i < 5; ++i) {
    EXPECT_GE(figures.coverage_curve[i], figures.coverage_curve[i - 1]);
  }
}

TEST(MeasureSamples, ComparesWithAtMostSoManyTransitions) {
  const Toy toy;
  const LibraryTransitions library = toy.Transitions(/*most=*/10);

  const SampleFigures figures =
      toy.Measure({{.name = "a", .qpos = {}, .qvel = {}}},
                  {Playback(toy, /*clip=*/1, /*frames=*/20)}, &library,
                  {.most_transitions = 5});

  EXPECT_EQ(figures.transitions->library, 10);
  EXPECT_EQ(figures.transitions->generated, 5);
  EXPECT_EQ(figures.all_transitions, 18);
}

TEST(MeasureSamples, SaysWhichShareOfWhatTheStudentCoversIsCovered) {
  const Toy toy;
  LibraryTransitions library = toy.Transitions();
  metrics::TransitionMatch student;
  student.library_distance.assign(58, 9);
  // Of the student's, two are of "sway" (after the 24 of "turn"), and one of
  // "tumble", to which nothing in "sway" is near. The first of "sway" is none
  // of what was sampled.
  for (const size_t covered : {25, 30, 50}) {
    student.library_distance[covered] = 0;
  }
  library.student = student;

  const SampleFigures figures =
      toy.Measure({{.name = "a", .qpos = {}, .qvel = {}}},
                  {Playback(toy, /*clip=*/1, /*frames=*/20)}, &library,
                  {.threshold = 1e-3});

  EXPECT_DOUBLE_EQ(figures.student_coverage, 2.0 / 3);
}

}  // namespace
}  // namespace sinew::sampling
