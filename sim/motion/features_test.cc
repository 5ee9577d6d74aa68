#include "sim/motion/features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "sim/motion/rotation.h"
#include "sim/motion/testing/sample_library.h"

namespace sinew::motion {
namespace {

using Eigen::Vector3d;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::Folder;
using ::testing::HasSubstr;
using testing::kFrames;
using testing::Sample;

const FeatureDefinition kDefinition = {.end_effectors = {"body"}};
constexpr char kFile[] = "vmp.features.safetensors";

// The sample with everything random, so that no wrong formula is right by
// chance. Its cycle turns by 0.6 rad.
Sample RandomSample() {
  Sample sample = testing::MakeSample();
  uint64_t seed = 1;
  for (auto& [name, tensor] : sample.frames) {
    if (name == "contact") continue;
    FillNormal({.seed = seed++}, tensor.mutable_float32());
    if (name.find("rotation") == std::string::npos) continue;
    const auto values = tensor.mutable_float32();
    for (size_t i = 0; i < values.size(); i += 4) {
      const Eigen::Quaterniond q = FromWxyz(&values[i]).normalized();
      ToWxyz(q, &values[i]);
    }
  }
  return sample;
}

std::unique_ptr<Library> MakeLibrary(const Sample& sample,
                                     const std::string& name) {
  EXPECT_THAT(Library::Save(sample.manifest, sample.frames, Folder(name)),
              IsOk());
  auto library = Library::Load(Folder(name));
  EXPECT_THAT(library, IsOk());
  return *std::move(library);
}

std::unique_ptr<const MotionFeatures> Open(
    const Library& library, const std::string& name,
    const FeatureDefinition& definition = kDefinition) {
  auto features = MotionFeatures::Open(library, definition, Folder(name));
  EXPECT_THAT(features, IsOk());
  return *std::move(features);
}

// Equation (1) of a frame as it stands in the world, seen from `heading`.
std::vector<double> Naive(const FrameView& frame,
                          const Eigen::Quaterniond& heading) {
  std::vector<double> m;
  const auto add = [&](const Vector3d& v) {
    for (int i = 0; i < 3; ++i) m.push_back(v[i]);
  };
  const auto seen = [&](const float* v) {
    return Vector3d(heading.conjugate() * Vector3d(v[0], v[1], v[2]));
  };
  const Eigen::Quaterniond root = FromWxyz(frame.root_rotation).normalized();
  m.push_back(frame.root_position[2]);
  add(heading.conjugate() * (root * Vector3d::UnitX()));
  add(heading.conjugate() * (root * Vector3d::UnitY()));
  add(seen(frame.root_linear_velocity));
  add(seen(frame.root_angular_velocity));
  m.push_back(frame.joint_position[0]);
  m.push_back(frame.joint_velocity[0]);
  add(seen(frame.body_position) - seen(frame.root_position));
  return m;
}

Eigen::Quaterniond HeadingOf(const FrameView& frame) {
  return YawRotation(Yaw(FromWxyz(frame.root_rotation).normalized()));
}

bool IsTheta(size_t i) { return i >= 1 && i < 7; }

// Mean and deviation of every feature, frame by frame from its own heading.
void NaiveStatistics(const Library& library, std::vector<double>* mean,
                     std::vector<double>* deviation) {
  std::vector<std::vector<double>> all;
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    for (int64_t t = 0; t < kFrames; ++t) {
      const FrameView frame = library.frame(clip, t);
      all.push_back(Naive(frame, HeadingOf(frame)));
    }
  }
  const auto count = static_cast<double>(all.size());
  mean->assign(all[0].size(), 0);
  deviation->assign(all[0].size(), 1);
  for (size_t i = 0; i < all[0].size(); ++i) {
    if (IsTheta(i)) continue;
    double squares = 0;
    for (const auto& m : all) (*mean)[i] += m[i] / count;
    for (const auto& m : all) squares += std::pow(m[i] - (*mean)[i], 2);
    (*deviation)[i] = std::sqrt(squares / count);
  }
}

// The window by the paper's words, from frames placed in the world.
void ExpectWindow(const Library& library, const MotionFeatures& features,
                  int clip, int64_t centre, int half) {
  std::vector<double> mean, deviation;
  NaiveStatistics(library, &mean, &deviation);
  std::vector<float> window((2 * half + 1) * features.width());
  features.Window(clip, centre, half, absl::MakeSpan(window));
  // Frames before the first one: from a start some cycles later.
  const int64_t later = library.clip(clip).loops() ? 5 * kFrames : 0;
  ReferenceFrame at(library), middle(library);
  middle.Load(clip, centre + later);
  const Eigen::Quaterniond heading = HeadingOf(middle.view());
  for (int64_t i = -half; i <= half; ++i) {
    int64_t t = centre + i + later;
    if (later == 0) t = std::clamp<int64_t>(t, 0, kFrames - 1);
    at.Load(clip, t);
    const std::vector<double> expected = Naive(at.view(), heading);
    for (size_t j = 0; j < expected.size(); ++j) {
      EXPECT_NEAR(window[(i + half) * features.width() + j],
                  (expected[j] - mean[j]) / deviation[j], 2e-4)
          << "frame " << i << " feature " << j;
    }
  }
}

TEST(MotionFeatures, AreThoseOfThePaperAroundEveryFrameOfALoopingClip) {
  const auto library = MakeLibrary(RandomSample(), "looping");
  const auto features = Open(*library, "looping");

  EXPECT_EQ(features->width(), 13 + 2 * 1 + 3 * 1);
  for (const int64_t t : {0, 1, 6, 11}) {
    ExpectWindow(*library, *features, /*clip=*/0, t, /*half=*/15);
  }
}

TEST(MotionFeatures, RepeatTheFirstAndTheLastFrameOfAClipThatEnds) {
  const auto library = MakeLibrary(RandomSample(), "ending");
  const auto features = Open(*library, "ending");

  for (const int64_t t : {0, 5, 11}) {
    ExpectWindow(*library, *features, /*clip=*/1, t, /*half=*/4);
  }
}

TEST(MotionFeatures, OfOneFrameLieInItsOwnHeading) {
  const auto library = MakeLibrary(RandomSample(), "single");
  const auto features = Open(*library, "single");

  ExpectWindow(*library, *features, /*clip=*/0, 7, /*half=*/0);
}

TEST(MotionFeatures, DoNotChangeWhenTheWorldIsTurnedAndMoved) {
  Sample sample = RandomSample();
  const auto library = MakeLibrary(sample, "here");
  const auto here = Open(*library, "here");
  const Eigen::Quaterniond turn = YawRotation(2);
  for (auto& [name, tensor] : sample.frames) {
    const auto values = tensor.mutable_float32();
    const bool rotation = name.find("rotation") != std::string::npos;
    const bool vector = name.find("position") != std::string::npos ||
                        name.find("_velocity") != std::string::npos;
    if (name.substr(0, 5) == "joint") continue;
    for (size_t i = 0; rotation && i < values.size(); i += 4) {
      ToWxyz(turn * FromWxyz(&values[i]), &values[i]);
    }
    for (size_t i = 0; !rotation && vector && i < values.size(); i += 3) {
      const Vector3d turned =
          turn * Vector3d(values[i], values[i + 1], values[i + 2]);
      for (int j = 0; j < 3; ++j) {
        values[i + j] = static_cast<float>(turned[j]);
      }
    }
  }
  const auto moved_library = MakeLibrary(sample, "there");
  const auto there = Open(*moved_library, "there");

  std::vector<float> a(9 * here->width()), b(a.size());
  here->Window(1, 5, 4, absl::MakeSpan(a));
  there->Window(1, 5, 4, absl::MakeSpan(b));

  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 2e-4) << i;
}

TEST(MotionFeatures, AreComputedOnceAndThenMapped) {
  const auto library = MakeLibrary(RandomSample(), "once");

  const auto first = Open(*library, "once");
  const auto second = Open(*library, "once");

  EXPECT_FALSE(first->file().found());
  EXPECT_TRUE(second->file().found());
  EXPECT_TRUE(std::equal(first->mean().begin(), first->mean().end(),
                         second->mean().begin()));
}

TEST(MotionFeatures, AreComputedAnewForAnotherLibraryOrDefinition) {
  Sample sample = RandomSample();
  Open(*MakeLibrary(sample, "stale"), "stale");
  sample.frames["joint_position"].mutable_float32()[3] += 1;

  const auto library = MakeLibrary(sample, "stale");
  const auto changed = Open(*library, "stale");

  EXPECT_FALSE(changed->file().found());
  ExpectWindow(*library, *changed, /*clip=*/0, 3, /*half=*/2);
  sample.manifest.set_bodies(0, "trunk");
  const auto renamed = MakeLibrary(sample, "stale");
  EXPECT_FALSE(
      Open(*renamed, "stale", {.end_effectors = {"trunk"}})->file().found());
}

TEST(MotionFeatures, AreComputedAnewWhereTheFileIsTruncatedOrNone) {
  const auto library = MakeLibrary(RandomSample(), "broken");
  const std::string path = JoinPath(Folder("broken"), kFile);
  Open(*library, "broken");
  const std::string whole = *ReadFile(path);

  for (const size_t size : {size_t{0}, size_t{20}, whole.size() - 4}) {
    ASSERT_THAT(WriteFileAtomically(path, whole.substr(0, size)), IsOk());
    EXPECT_FALSE(Open(*library, "broken")->file().found()) << size;
    EXPECT_EQ(*ReadFile(path), whole);
  }
}

TEST(MotionFeatures, StayInMemoryWhereTheFolderCannotBeWritten) {
  const auto library = MakeLibrary(RandomSample(), "readonly");

  const auto features =
      MotionFeatures::Open(*library, kDefinition, Folder("nowhere/at/all"));

  ASSERT_THAT(features, IsOk());
  EXPECT_THAT((*features)->file().kept(),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("nowhere")));
  ExpectWindow(*library, **features, /*clip=*/0, 3, /*half=*/2);
}

TEST(MotionFeatures, NameTheEndEffectorThatIsNoBody) {
  const auto library = MakeLibrary(RandomSample(), "names");
  const auto open = [&](std::vector<std::string> names) {
    return MotionFeatures::Open(*library, {.end_effectors = std::move(names)},
                                Folder("names"));
  };
  EXPECT_THAT(open({"hand"}), StatusIs(absl::StatusCode::kInvalidArgument,
                                       HasSubstr("(body), found \"hand\"")));
  EXPECT_THAT(open({"body", "body"}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("found \"body\" twice")));
  EXPECT_THAT(open({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                 HasSubstr("found none")));
}

}  // namespace
}  // namespace sinew::motion
