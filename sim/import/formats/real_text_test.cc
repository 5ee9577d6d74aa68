// The readers of text formats on recorded files, below the folder that
// SINEW_DATA names.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/bvh.h"
#include "sim/import/formats/first_frame.h"
#include "sim/import/formats/testing/check_clip.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Eigen::Vector3d;

class RealFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("SINEW_DATA");
    if (data == nullptr) GTEST_SKIP() << "SINEW_DATA is unset";
    motions_ = JoinPath(data, "motions");
  }

  // Paths below the motions with an extension.
  std::vector<std::string> Files(const std::string& extension) const {
    std::vector<std::string> found;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(motions_)) {
      if (entry.path().extension() == extension) {
        found.push_back(entry.path().string().substr(motions_.size() + 1));
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  std::string Read(const std::string& path) const {
    auto bytes = ReadFile(JoinPath(motions_, path));
    EXPECT_THAT(bytes, IsOk());
    return bytes.ok() ? *std::move(bytes) : "";
  }

  absl::StatusOr<SourceClip> ReadBvh(const std::string& path) const {
    auto clip = ParseBvh(Read(path), path, path, {});
    if (clip.ok()) testing::CheckClip(*clip);
    return clip;
  }

  absl::StatusOr<SourceClip> ReadAmc(const std::string& path,
                                     const std::string& asf_path) const {
    auto asf = ParseAsf(Read(asf_path), asf_path);
    if (!asf.ok()) return asf.status();
    auto clip = ParseAmc(Read(path), *asf, path, path, {});
    if (clip.ok()) testing::CheckClip(*clip);
    return clip;
  }

  // The skeleton beside an AMC, relative to the motions; another subject's if
  // it has none.
  std::string AsfOf(const std::string& amc) const {
    const auto candidates = AsfCandidates(JoinPath(motions_, amc));
    if (!candidates.empty()) return candidates[0].substr(motions_.size() + 1);
    return "cmu_amc/07/07.asf";
  }

  std::string motions_;
};

// What is known of a collection, by the start of its files' paths.
struct Facts {
  const char* path;
  double metres_per_unit;
  const char* up_axis;
  double frames_per_second;
};

constexpr double kCmuUnit = 0.0254 / 0.45;
constexpr double kOwnSize = 0;  // no usual unit
constexpr Facts kFacts[] = {
    {"animated_drawings_bvh/dab", kOwnSize, "z", 30},
    {"animated_drawings_bvh/jesse_dance", 0.01, "y", 100},
    {"animated_drawings_bvh/jumping_jacks", kCmuUnit, "y", 30},
    {"animated_drawings_bvh/jumping.", kOwnSize, "z", 119.875},
    {"animated_drawings_bvh/wave_hello", kOwnSize, "z", 119.875},
    {"animated_drawings_bvh/zombie", kOwnSize, "z", 30},
    {"cmu_bvh/max_friendly/scaled", 1, "y", 120},
    {"cmu_bvh/other/1", 0.01, "y", 120},
    {"cmu_bvh/", kCmuUnit, "y", 120},
    {"makehuman_bvh/", 0.1, "z", 24},
    {"mass_bvh/", 0.01, "y", 120},
    {"react_idle/", 1, "y", 24},
};

TEST_F(RealFiles, OfBvhAllParseInTheirUnitUpAxisAndRate) {
  const std::vector<std::string> paths = Files(".bvh");
  ASSERT_THAT(paths, Not(IsEmpty()));
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const auto clip = ReadBvh(path);
    ASSERT_THAT(clip, IsOk());
    const auto facts = std::find_if(
        std::begin(kFacts), std::end(kFacts),
        [&](const Facts& f) { return absl::StartsWith(path, f.path); });
    ASSERT_NE(facts, std::end(kFacts)) << "an unknown collection";
    EXPECT_EQ(clip->facts.up_axis(), facts->up_axis);
    EXPECT_NEAR(clip->facts.frames_per_second(), facts->frames_per_second, 0.2);
    if (facts->metres_per_unit == kOwnSize) {
      EXPECT_NEAR(clip->facts.metres_per_unit(), 0.04, 0.005);
      EXPECT_THAT(clip->warnings, Not(IsEmpty()));
    } else {
      EXPECT_DOUBLE_EQ(clip->facts.metres_per_unit(), facts->metres_per_unit);
    }
  }
  std::printf("%zu BVH files\n", paths.size());
}

TEST_F(RealFiles, OfAmcAllParseButTheOneThatIsCutShort) {
  const std::vector<std::string> paths = Files(".amc");
  ASSERT_THAT(paths, Not(IsEmpty()));
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const auto clip = ReadAmc(path, AsfOf(path));
    if (absl::StrContains(path, "/broken/")) {
      EXPECT_THAT(clip, StatusIs(absl::StatusCode::kInvalidArgument,
                                 AllOf(HasSubstr("07_12.amc: line "),
                                       HasSubstr("expected numbers of bone"))));
      std::printf("%s\n", std::string(clip.status().message()).c_str());
      continue;
    }
    ASSERT_THAT(clip, IsOk());
    EXPECT_DOUBLE_EQ(clip->facts.metres_per_unit(), kCmuUnit);
    EXPECT_EQ(clip->facts.up_axis(), "y");
    EXPECT_EQ(clip->facts.frames_per_second(), 120);
    EXPECT_THAT(clip->warnings, IsEmpty());
  }
  std::printf("%zu AMC files\n", paths.size());
}

// A mutation of each kind that happens to files: a cut at any place.
TEST_F(RealFiles, OfBvhGiveAnErrorOrAClipWhereverTheyAreCut) {
  const std::string whole = Read("makehuman_bvh/walk1.bvh");
  for (size_t size = 0; size < whole.size(); size += 997) {
    const auto clip = ParseBvh(whole.substr(0, size), "cut", "cut.bvh", {});
    EXPECT_THAT(clip, StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr("cut.bvh: line ")))
        << size;
  }
}

// True of CMU's BVH for MotionBuilder.
bool HasRestFrame(const std::string& path) {
  return absl::StartsWith(path, "cmu_bvh/0") ||
         absl::StartsWith(path, "cmu_bvh/49") ||
         absl::StartsWith(path, "cmu_bvh/walk_run/") ||
         absl::StartsWith(path, "cmu_bvh/other/01_01");
}

TEST_F(RealFiles, StartWithARestFrameInOneDialectOnly) {
  for (const std::string& path : Files(".bvh")) {
    // Time is short: the long clips of a dialect tell no more.
    if (std::filesystem::file_size(JoinPath(motions_, path)) > 500000) continue;
    const auto clip = ReadBvh(path);
    ASSERT_THAT(clip, IsOk());
    EXPECT_EQ(FirstFrameIsRest(*clip), HasRestFrame(path)) << path;
  }
}

// Joints of the legs in CMU's BVH, and in ASF.
constexpr std::pair<const char*, const char*> kLegs[] = {
    {"Hips", "root"},
    {"LeftUpLeg", "lfemur"},
    {"LeftLeg", "ltibia"},
    {"LeftFoot", "lfoot"},
    {"LeftToeBase", "ltoes"},
    {"LeftToeBase_end", "ltoes_end"},
    {"RightUpLeg", "rfemur"},
    {"RightLeg", "rtibia"},
    {"RightFoot", "rfoot"},
    {"RightToeBase", "rtoes"},
    {"RightToeBase_end", "rtoes_end"},
};

// Largest distance between joints of the legs over the clip, m.
double LegDistance(const SourceClip& bvh, const SourceClip& amc) {
  double largest = 0;
  for (size_t i = 0; i < std::min(bvh.poses.size(), amc.poses.size()); ++i) {
    const std::vector<Vector3d> a = WorldPositions(bvh.skeleton, bvh.poses[i]);
    const std::vector<Vector3d> b = WorldPositions(amc.skeleton, amc.poses[i]);
    for (const auto& [in_bvh, in_asf] : kLegs) {
      largest = std::max(
          largest,
          (a[bvh.skeleton.Find(in_bvh)] - b[amc.skeleton.Find(in_asf)]).norm());
    }
  }
  return largest;
}

TEST_F(RealFiles, OfCmuHaveTheSameLegsInBvhAndAmc) {
  std::map<std::string, std::string> amc_of;  // by stem
  for (const std::string& path : Files(".amc")) {
    amc_of[std::filesystem::path(path).stem()] = path;
  }
  int pairs = 0;
  for (const std::string& path : Files(".bvh")) {
    const auto amc_path =
        amc_of.find(std::filesystem::path(path).stem().string().substr(0, 5));
    if (!HasRestFrame(path) || amc_path == amc_of.end()) continue;
    SCOPED_TRACE(path);
    auto bvh = ReadBvh(path);
    const auto amc = ReadAmc(amc_path->second, AsfOf(amc_path->second));
    ASSERT_THAT(bvh, IsOk());
    ASSERT_THAT(amc, IsOk());

    DropFirstPose(*bvh);

    EXPECT_EQ(bvh->poses.size(), amc->poses.size());
    const double distance = LegDistance(*bvh, *amc);
    EXPECT_LT(distance, 1e-4);
    std::printf("%s, %s: legs within %.4f mm\n", path.c_str(),
                amc_path->second.c_str(), distance * 1e3);
    ++pairs;
  }
  EXPECT_GT(pairs, 10);
}

}  // namespace
}  // namespace sinew::import
