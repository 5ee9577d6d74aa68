#include "tools/sampling/sampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "proto/sinew/v1/graph.pb.h"
#include "tools/sampling/sample_starts.h"
#include "tools/sampling/testing/toy_sampler.h"

namespace sinew::sampling {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const size_t kLatent = bundle::testing::LatentWidths().latent;

struct Toy : testing::ToySampler {
  std::vector<SampleStart> Starts(int count) const {
    return MakeStarts(sampler->law(), world.library.get(),
                      {.kind = StartKind::Kind::kClip}, count, /*seed=*/1,
                      StopToken())
        .value();
  }
  std::vector<SampleMotion> Run(const SampleOrder& order) const {
    return sampler->Run(order, StopToken()).value();
  }
};

absl::Status RefusalOf(const bundle::Bundle& bundle) {
  return Sampler::Create(bundle).status();
}

v1::Graph& SampleGraph(bundle::Bundle& bundle) {
  for (v1::Graph& graph : *bundle.graph.mutable_graphs()) {
    if (graph.name() == "sample") return graph;
  }
  ADD_FAILURE() << "no graph \"sample\"";
  return *bundle.graph.mutable_graphs(0);
}

TEST(Sampler, RecordsTheStartAndEveryStep) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(2);

  const auto motions = toy.Run({.starts = starts,
                                .per_start = 2,
                                .steps = 5,
                                .noise = 1.0,
                                .keep_qpos = 3});

  ASSERT_THAT(motions, SizeIs(4));
  const auto width = static_cast<size_t>(toy.sampler->num_features());
  EXPECT_EQ(width, bundle::testing::LatentWidths().self);
  const size_t nq = starts[0].qpos.size();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(motions[i].start, static_cast<int>(i) / 2);
    EXPECT_EQ(motions[i].sample, static_cast<int64_t>(i));
    EXPECT_FALSE(motions[i].diverged);
    EXPECT_EQ(motions[i].frames(), 6);
    EXPECT_THAT(motions[i].states, SizeIs(6 * width));
    EXPECT_EQ(motions[i].path.frames(), 6);
    EXPECT_THAT(motions[i].path.points, SizeIs(6 * 4 * 3));
    EXPECT_THAT(motions[i].latent, SizeIs(5 * kLatent));
    EXPECT_THAT(motions[i].latent_mean, SizeIs(5 * kLatent));
    EXPECT_EQ(motions[i].energy.frames, 6);
    EXPECT_THAT(motions[i].qpos, SizeIs(i < 3 ? 6 * nq : 0));
  }
  EXPECT_EQ(
      std::vector<double>(motions[0].qpos.begin(),
                          motions[0].qpos.begin() + static_cast<ptrdiff_t>(nq)),
      starts[0].qpos);
}

TEST(Sampler, GivesTheSameBitsForAnyNumberOfThreads) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(5);
  SampleOrder order = {.starts = starts,
                       .per_start = 4,  // groups of 8, 8 and 4
                       .steps = 6,
                       .noise = 1.0,
                       .seed = 7};

  const auto one = toy.Run(order);
  order.threads = 3;
  const auto three = toy.Run(order);

  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].states, three[i].states) << i;
    EXPECT_EQ(one[i].latent, three[i].latent) << i;
    EXPECT_EQ(one[i].skate.sum_m_per_s, three[i].skate.sum_m_per_s) << i;
  }
}

TEST(Sampler, SamplesOfOneStartDifferByTheirNoise) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(1);

  const auto noisy =
      toy.Run({.starts = starts, .per_start = 2, .steps = 4, .noise = 1.0});
  const auto calm =
      toy.Run({.starts = starts, .per_start = 2, .steps = 4, .noise = 0.0});

  EXPECT_NE(noisy[0].states, noisy[1].states);
  EXPECT_EQ(calm[0].states, calm[1].states);
  EXPECT_EQ(calm[0].latent, calm[0].latent_mean);
}

TEST(Sampler, TheScaleMultipliesTheSameDraws) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(1);

  const auto once = toy.Run({.starts = starts, .steps = 1, .noise = 1.0});
  const auto twice = toy.Run({.starts = starts, .steps = 1, .noise = 2.0});

  for (size_t i = 0; i < kLatent; ++i) {
    EXPECT_EQ(once[0].latent_mean[i], twice[0].latent_mean[i]);
    const float drawn = once[0].latent[i] - once[0].latent_mean[i];
    EXPECT_NE(drawn, 0);
    EXPECT_NEAR(twice[0].latent[i] - twice[0].latent_mean[i], 2 * drawn, 1e-5);
  }
}

TEST(Sampler, ADifferentSeedDrawsAnew) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(1);

  const auto one = toy.Run({.starts = starts, .steps = 2, .noise = 1.0});
  const auto other =
      toy.Run({.starts = starts, .steps = 2, .noise = 1.0, .seed = 1});

  EXPECT_NE(one[0].latent, other[0].latent);
}

TEST(Sampler, TheZeroActionUsesNoNetwork) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(1);

  const auto motions =
      toy.Run({.starts = starts, .steps = 3, .noise = std::nullopt});

  EXPECT_EQ(motions[0].frames(), 4);
  EXPECT_THAT(motions[0].latent, SizeIs(0));
}

TEST(Sampler, ADivergedSampleEndsWithItsLastSoundState) {
  const Toy toy;
  std::vector<SampleStart> starts = toy.Starts(2);
  starts[0].qvel[0] = 1e12;  // beyond what MuJoCo takes for a velocity

  const auto motions =
      toy.Run({.starts = starts, .steps = 3, .noise = std::nullopt});

  ASSERT_THAT(motions, SizeIs(2));
  EXPECT_TRUE(motions[0].diverged);
  EXPECT_EQ(motions[0].frames(), 1);
  EXPECT_FALSE(motions[1].diverged);
  EXPECT_EQ(motions[1].frames(), 4);
}

TEST(Sampler, StopsWhenItIsAskedTo) {
  const Toy toy;
  const std::vector<SampleStart> starts = toy.Starts(1);
  StopSource source;
  source.request_stop();

  EXPECT_THAT(toy.sampler
                  ->Run({.starts = starts, .steps = 3, .noise = 1.0},
                        source.get_token())
                  .status(),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(Sampler, RefusesABundleWithoutTheGraph) {
  Toy toy;
  SampleGraph(toy.bundle).set_name("another");

  EXPECT_THAT(RefusalOf(toy.bundle),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(toy.bundle.directory),
                             HasSubstr("expected a graph \"sample\""))));
}

TEST(Sampler, RefusesAGraphWithoutTheLatent) {
  Toy toy;
  for (v1::Tap& tap : *SampleGraph(toy.bundle).mutable_taps()) {
    if (tap.name() == "latent") tap.set_name("z");
  }

  EXPECT_THAT(RefusalOf(toy.bundle),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a tap \"latent\", found action, "
                                 "z")));
}

TEST(Sampler, RefusesAWidthThatIsNotOfTheBodysOwnBlocks) {
  Toy toy;
  toy.bundle.manifest.mutable_task()->mutable_observation()->clear_blocks();
  toy.bundle.manifest.mutable_task()->mutable_observation()->add_blocks(
      v1::Observation::BLOCK_SELF_CONTACT);

  EXPECT_THAT(RefusalOf(toy.bundle),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("the body's own (2), found width 33")));
}

TEST(Sampler, RefusesTargetsThatNeedAReference) {
  Toy toy;
  toy.bundle.manifest.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE);

  EXPECT_THAT(RefusalOf(toy.bundle),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("action.placement"),
                             HasSubstr("AROUND_NEXT_REFERENCE"))));
}

}  // namespace
}  // namespace sinew::sampling
