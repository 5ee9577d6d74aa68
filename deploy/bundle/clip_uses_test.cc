#include "deploy/bundle/clip_uses.h"

#include <initializer_list>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"

namespace sinew::bundle {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr v1::ClipUse kTrainedOn = v1::CLIP_USE_TRAINED_ON;
constexpr v1::ClipUse kBySource = v1::CLIP_USE_SOURCE_TRAINED_ON;
constexpr v1::ClipUse kLeftOut = v1::CLIP_USE_LEFT_OUT;
constexpr v1::ClipUse kUnknown = v1::CLIP_USE_UNKNOWN;

v1::MotionLibrary Library(std::initializer_list<const char*> names,
                          std::initializer_list<int> left_out = {}) {
  v1::MotionLibrary library;
  for (const char* name : names) library.add_clips()->set_name(name);
  for (const int clip : left_out) {
    library.mutable_clips(clip)->set_left_out(true);
  }
  return library;
}

v1::RunInputs::Source Source(
    std::initializer_list<std::pair<const char*, v1::ClipUse>> clips) {
  v1::RunInputs::Source source;
  for (const auto& [name, use] : clips) {
    source.add_clips(std::string(name) + ": a studio (CC-BY-4.0)");
    source.add_clip_uses(use);
  }
  return source;
}

TEST(ClipUses, AreTrainedOnWhereStartsAreDrawn) {
  const v1::MotionLibrary library = Library({"walk", "run", "jump"}, {2});
  v1::Start start;

  EXPECT_THAT(ClipUsesOfRun(start, library, {}),
              ElementsAre(Pair("jump", kLeftOut), Pair("run", kTrainedOn),
                          Pair("walk", kTrainedOn)));

  start.add_only_clips("run");
  EXPECT_THAT(ClipUsesOfRun(start, library, {}),
              ElementsAre(Pair("jump", kLeftOut), Pair("run", kTrainedOn),
                          Pair("walk", kLeftOut)));
}

TEST(ClipUses, OfSourcesCountWhereTheRunItselfDrewNone) {
  const v1::MotionLibrary library =
      Library({"walk", "run", "jump", "roll"}, {1, 2, 3});

  const ClipUses uses = ClipUsesOfRun(
      v1::Start(), library,
      {Source({{"walk", kLeftOut}, {"run", kTrainedOn}, {"jump", kLeftOut}}),
       Source({{"run", kUnknown}, {"jump", kBySource}, {"roll", kUnknown}}),
       Source({{"climb", kTrainedOn}, {"fall", kLeftOut}})});

  EXPECT_THAT(uses,
              ElementsAre(Pair("climb", kBySource), Pair("fall", kLeftOut),
                          Pair("jump", kBySource), Pair("roll", kUnknown),
                          Pair("run", kBySource), Pair("walk", kTrainedOn)));
}

TEST(ClipUses, AreUnknownOfSourcesThatDoNotSay) {
  const v1::MotionLibrary library = Library({"walk", "run", "jump"}, {1, 2});
  v1::RunInputs::Source old = Source({{"run", kLeftOut}});
  old.clear_clip_uses();

  EXPECT_THAT(ClipUsesOfRun(v1::Start(), library, {old}),
              ElementsAre(Pair("jump", kLeftOut), Pair("run", kUnknown),
                          Pair("walk", kTrainedOn)));
  // Known by its digest alone: whatever nobody else was trained on.
  EXPECT_THAT(
      ClipUsesOfRun(v1::Start(), library,
                    {v1::RunInputs::Source(), Source({{"jump", kTrainedOn}})}),
      ElementsAre(Pair("jump", kBySource), Pair("run", kUnknown),
                  Pair("walk", kTrainedOn)));
}

TEST(ClipUses, AreReadByNameAndNotThereInOldBundles) {
  v1::BundleProvenance provenance;
  provenance.add_clips("walk: a studio (MIT)");
  provenance.add_clips("run");
  EXPECT_THAT(ClipUsesOf(provenance), IsEmpty());

  provenance.add_clip_uses(kLeftOut);
  provenance.add_clip_uses(kTrainedOn);
  EXPECT_THAT(ClipUsesOf(provenance),
              ElementsAre(Pair("run", kTrainedOn), Pair("walk", kLeftOut)));
  // Of two entries of one name.
  provenance.add_clips("walk: another (MIT)");
  provenance.add_clip_uses(kBySource);
  EXPECT_THAT(ClipUsesOf(provenance),
              ElementsAre(Pair("run", kTrainedOn), Pair("walk", kBySource)));
}

}  // namespace
}  // namespace sinew::bundle
