#include "tools/sampling/sample_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sampling/free_body.h"

namespace sinew::sampling {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

struct Toy {
  world::testing::ToyWorld world =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  bundle::Bundle bundle =
      bundle::ReadBundle(bundle::testing::WriteToyLatent(world)).value();
  std::shared_ptr<const BodyLaw> law =
      BodyLaw::Create(bundle, bundle::testing::LatentWidths().self).value();

  absl::StatusOr<std::vector<SampleStart>> Make(const std::string& start,
                                                int count,
                                                uint64_t seed = 0) const {
    return MakeStarts(*law, world.library.get(), ParseStart(start).value(),
                      count, seed, StopToken());
  }
};

TEST(ParseStart, KnowsItsKinds) {
  EXPECT_EQ(ParseStart("clip")->kind, StartKind::Kind::kClip);
  EXPECT_EQ(ParseStart("standing")->kind, StartKind::Kind::kStanding);
  EXPECT_EQ(ParseStart("fallen")->kind, StartKind::Kind::kFallen);

  const auto given = ParseStart("a:b:1.5");

  ASSERT_THAT(given, IsOk());
  EXPECT_EQ(given->kind, StartKind::Kind::kGiven);
  EXPECT_EQ(given->clip, "a:b");
  EXPECT_EQ(given->seconds, 1.5);
}

TEST(ParseStart, SaysWhatItExpects) {
  for (const char* text : {"", "walk", ":1", "walk:", "walk:-1", "walk:x"}) {
    EXPECT_THAT(ParseStart(text).status(),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("clip, standing, fallen or CLIP:SECONDS")))
        << text;
  }
}

TEST(MakeStarts, DrawsFramesOfClipsAlikeForOneSeed) {
  const Toy toy;

  const auto one = toy.Make("clip", 8, 1);
  const auto again = toy.Make("clip", 8, 1);
  const auto other = toy.Make("clip", 8, 2);

  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(*one, SizeIs(8));
  bool differs = false;
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ((*one)[i].name, (*again)[i].name);
    EXPECT_EQ((*one)[i].qpos, (*again)[i].qpos);
    differs = differs || (*one)[i].name != (*other)[i].name;
  }
  EXPECT_TRUE(differs);
}

TEST(MakeStarts, DrawsUprightBodiesAlone) {
  const Toy toy;
  FreeBody body(toy.law);

  const auto starts = toy.Make("clip", 16);

  ASSERT_THAT(starts, IsOk());
  for (const SampleStart& start : *starts) {
    body.Start(start.qpos, start.qvel);
    EXPECT_GE(body.UprightHeight(),
              kUprightShare * toy.law->standing_height() - 1e-6)
        << start.name;
  }
}

// Of clips that move faster than that as well.
TEST(MakeStarts, DrawsStandingBodiesWhoseRootHardlyMoves) {
  const Toy toy;
  const auto fastest = [](const std::vector<SampleStart>& starts) {
    double fastest = 0;
    for (const SampleStart& start : starts) {
      fastest = std::max(
          fastest, std::hypot(start.qvel[0], start.qvel[1], start.qvel[2]));
    }
    return fastest;
  };

  const auto upright = toy.Make("clip", 32);
  const auto standing = toy.Make("standing", 32);

  ASSERT_THAT(upright, IsOk());
  ASSERT_THAT(standing, IsOk());
  ASSERT_THAT(*standing, SizeIs(32));
  EXPECT_GT(fastest(*upright), kStandingSpeed);
  EXPECT_LT(fastest(*standing), kStandingSpeed + 1e-6);
}

TEST(MakeStarts, TakesTheStateOfAGivenClip) {
  const Toy toy;

  const auto starts = toy.Make("sway:0.2", /*count=*/5);

  ASSERT_THAT(starts, IsOk());
  ASSERT_THAT(*starts, SizeIs(1));
  EXPECT_EQ((*starts)[0].name, "sway at 0.20 s");
  const motion::FrameView frame = toy.world.library->frame(1, 6);
  EXPECT_FLOAT_EQ(static_cast<float>((*starts)[0].qpos[2]),
                  frame.root_position[2]);
}

TEST(MakeStarts, LaysBodiesOnTheFloorAtRest) {
  const Toy toy;

  const auto starts = toy.Make("fallen", 2);

  ASSERT_THAT(starts, IsOk());
  ASSERT_THAT(*starts, SizeIs(2));
  EXPECT_THAT((*starts)[0].name, StartsWith("fallen"));
  EXPECT_THAT((*starts)[0].qvel, Each(0));
  EXPECT_NE((*starts)[0].qpos, (*starts)[1].qpos);
}

TEST(MakeStarts, StopsWhenItIsAskedTo) {
  const Toy toy;
  StopSource source;
  source.request_stop();

  for (const char* start : {"clip", "standing", "fallen"}) {
    EXPECT_THAT(MakeStarts(*toy.law, toy.world.library.get(),
                           ParseStart(start).value(), 2, 0, source.get_token())
                    .status(),
                StatusIs(absl::StatusCode::kCancelled))
        << start;
  }
}

TEST(MakeStarts, SaysWhatIsWrong) {
  const Toy toy;

  EXPECT_THAT(toy.Make("sway:9", 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("sway"), HasSubstr("found 9"))));
  EXPECT_THAT(toy.Make("run:1", 1).status(),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("\"run\"")));
  EXPECT_THAT(
      MakeStarts(*toy.law, nullptr, {.kind = StartKind::Kind::kClip}, 1, 0,
                 StopToken())
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--motions")));
}

}  // namespace
}  // namespace sinew::sampling
