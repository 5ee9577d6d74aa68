#include "sim/motion/split.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace sinew::motion {
namespace {

v1::ClipInfo Clip(const std::string& name, const std::string& trial,
                  const std::string& mirror_of = "") {
  v1::ClipInfo clip;
  clip.set_name(name);
  clip.set_trial(trial);
  clip.set_mirror_of(mirror_of);
  return clip;
}

TEST(Split, KeepsARecordingTogether) {
  EXPECT_EQ(SplitKey(Clip("02_04", "cmu/02_04")),
            SplitKey(Clip("02_04_poses", "cmu/02_04")));
  EXPECT_EQ(SplitKey(Clip("02_04", "cmu/02_04")),
            SplitKey(Clip("02_04_mirror", "cmu/02_04", "02_04")));
}

TEST(Split, GoesByNameWhereTheRecordingIsUnknown) {
  EXPECT_EQ(SplitKey(Clip("walk", "")), "walk");
  EXPECT_EQ(SplitKey(Clip("walk_mirror", "")), "walk");
  EXPECT_EQ(SplitKey(Clip("reflection", "", "walk")), "walk");
}

TEST(Split, LeavesOutTheShareThatWasAskedFor) {
  for (const double share : {0.05, 0.15, 0.5}) {
    int left_out = 0;
    for (int i = 0; i < 4000; ++i) {
      left_out +=
          IsLeftOut(absl::StrFormat("cmu/%02d_%02d", i / 40, i % 40), share);
    }
    // Five standard deviations at one half.
    EXPECT_NEAR(left_out / 4000.0, share, 0.04) << share;
  }
}

TEST(Split, LeavesOutNothingOrAllAtTheEnds) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(IsLeftOut(absl::StrCat("trial", i), 0));
    EXPECT_TRUE(IsLeftOut(absl::StrCat("trial", i), 1));
  }
}

TEST(Split, OnlyGrowsWithTheShare) {
  for (int i = 0; i < 500; ++i) {
    const std::string key = absl::StrCat("trial", i);
    if (IsLeftOut(key, 0.1)) {
      EXPECT_TRUE(IsLeftOut(key, 0.2)) << key;
    }
  }
}

TEST(Split, LeavesOutABlendWithEitherOfItsRecordings) {
  constexpr double kShare = 0.5;
  std::string in, out;
  for (int i = 0; in.empty() || out.empty(); ++i) {
    const std::string trial = absl::StrCat("trial", i);
    (IsLeftOut(trial, kShare) ? out : in) = trial;
  }
  const auto left_out = [&](const std::string& first,
                            const std::string& second) {
    v1::ClipInfo clip = Clip("blend", first);
    clip.mutable_blend()->set_trial(second);
    return IsLeftOut(clip, kShare);
  };
  const auto of_file = [&](const std::string& second) {
    v1::ClipInfo clip = Clip("blend", in);
    clip.mutable_blend()->set_source_file(second);
    return IsLeftOut(clip, kShare);
  };
  EXPECT_TRUE(of_file("folder/" + out + "_mirror.bvh"));
  EXPECT_TRUE(of_file(out + ".bvh"));
  EXPECT_FALSE(of_file("folder/" + in + "_mirror.bvh"));
  EXPECT_FALSE(IsLeftOut(Clip("one", in), kShare));
  EXPECT_FALSE(left_out(in, in));
  EXPECT_TRUE(left_out(in, out));
  EXPECT_TRUE(left_out(out, in));
}

}  // namespace
}  // namespace sinew::motion
