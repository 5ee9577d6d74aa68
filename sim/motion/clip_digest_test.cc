#include "sim/motion/clip_digest.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "common/check.h"
#include "sim/motion/testing/sample_library.h"

namespace sinew::motion {
namespace {

std::vector<std::string> DigestsOf(const testing::Sample& sample,
                                   const std::string& name) {
  const absl::Status saved =
      Library::Save(sample.manifest, sample.frames, testing::Folder(name));
  SINEW_CHECK(saved.ok()) << saved;
  const auto library = Library::Load(testing::Folder(name));
  SINEW_CHECK(library.ok()) << library.status();
  return ClipDigests(**library);
}

TEST(ClipDigests, TellClipsApart) {
  const auto digests = DigestsOf(testing::MakeSample(), "apart");

  ASSERT_EQ(digests.size(), 2u);
  EXPECT_EQ(digests[0].size(), 64u);
  EXPECT_NE(digests[0], digests[1]);
}

TEST(ClipDigests, DoNotDependOnNamesFiguresAndSides) {
  testing::Sample sample = testing::MakeSample();
  v1::ClipInfo& clip = *sample.manifest.mutable_clips(0);
  clip.set_name("another");
  clip.set_licence("free");
  clip.set_trial("arc");
  clip.set_left_out(true);
  clip.mutable_quality()->set_peak_joint_speed(3);

  EXPECT_EQ(DigestsOf(sample, "renamed"),
            DigestsOf(testing::MakeSample(), "plain"));
}

TEST(ClipDigests, ChangeWithAFrameAndWithThePeriod) {
  const auto before = DigestsOf(testing::MakeSample(), "before");
  testing::Sample sample = testing::MakeSample();
  HostTensor& joints = sample.frames.at("joint_position");
  std::vector<float> values(joints.float32().begin(), joints.float32().end());
  values[testing::kFrames] += 0.5f;  // the first row of the second clip
  joints = HostTensor::Float32({2 * testing::kFrames, 1}, values);
  sample.manifest.mutable_clips(0)->set_cycle_x(0.25);

  const auto after = DigestsOf(sample, "after");

  EXPECT_NE(after[0], before[0]);
  EXPECT_NE(after[1], before[1]);

  sample.manifest.mutable_clips(0)->set_cycle_x(
      testing::MakeSample().manifest.clips(0).cycle_x());
  EXPECT_EQ(DigestsOf(sample, "one")[0], before[0]);
}

}  // namespace
}  // namespace sinew::motion
