#include "common/segment/episode_actor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace sinew {
namespace {

v1::Distillation Shares(double teacher, double prior) {
  v1::Distillation distillation;
  distillation.set_teacher_share(teacher);
  distillation.set_prior_share(prior);
  return distillation;
}

TEST(EpisodeActorTest, IsDrawnByTheShares) {
  const v1::Distillation shares = Shares(0.2, 0.5);
  std::map<EpisodeActor, int> counts;
  for (int environment = 0; environment < 100; ++environment) {
    for (int episode = 0; episode < 100; ++episode) {
      ++counts[WhoActs(shares, 7, environment, episode)];
    }
  }

  // Six standard deviations of 10000 draws are 300 at most.
  EXPECT_NEAR(counts[EpisodeActor::kTeacher], 2000, 300);
  EXPECT_NEAR(counts[EpisodeActor::kPrior], 5000, 300);
  EXPECT_NEAR(counts[EpisodeActor::kPolicy], 3000, 300);
}

TEST(EpisodeActorTest, DependsOnSeedEnvironmentAndEpisode) {
  const v1::Distillation shares = Shares(0, 0.5);
  int seeds = 0, environments = 0, episodes = 0;
  for (int i = 1; i < 50; ++i) {
    const EpisodeActor first = WhoActs(shares, 0, 0, 0);
    seeds += WhoActs(shares, i, 0, 0) != first;
    environments += WhoActs(shares, 0, i, 0) != first;
    episodes += WhoActs(shares, 0, 0, i) != first;
  }
  for (const int differing : {seeds, environments, episodes}) {
    EXPECT_GT(differing, 10);
    EXPECT_LT(differing, 40);
  }
}

TEST(EpisodeActorTest, ThePriorWaitsForItsFirstEpisode) {
  v1::Distillation shares = Shares(0.25, 0.75);
  shares.set_prior_first_episode(50);
  int teacher = 0;
  for (int i = 0; i < 100; ++i) {
    const EpisodeActor actor = WhoActs(shares, 1, 3, i);
    EXPECT_EQ(actor == EpisodeActor::kTeacher,
              WhoActs(Shares(0.25, 0.75), 1, 3, i) == EpisodeActor::kTeacher);
    teacher += actor == EpisodeActor::kTeacher;
    if (actor == EpisodeActor::kTeacher) continue;
    EXPECT_EQ(actor, i < 50 ? EpisodeActor::kPolicy : EpisodeActor::kPrior)
        << i;
  }
  EXPECT_GT(teacher, 0);
}

TEST(EpisodeActorTest, TheEndsOfTheShares) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(WhoActs({}, 1, i, i), EpisodeActor::kPolicy);
    EXPECT_EQ(WhoActs(Shares(1, 0), 1, i, i), EpisodeActor::kTeacher);
    EXPECT_EQ(WhoActs(Shares(0, 1), 1, i, i), EpisodeActor::kPrior);
    EXPECT_NE(WhoActs(Shares(0.5, 0.5), 1, i, i), EpisodeActor::kPolicy);
  }
}

}  // namespace
}  // namespace sinew
