#include "sim/import/importer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "nlohmann/json.hpp"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using Json = nlohmann::json;

class ImporterTest : public ::testing::Test {
 protected:
  ImporterTest() {
    auto loaded = character::Character::Load("humanoid", v1::Physics());
    EXPECT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
  }

  // A path of this test's own.
  static std::string Path(const std::string& name) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return JoinPath(JoinPath(::testing::TempDir(), test->name()), name);
  }
  static std::string Write(const std::string& name, const std::string& text) {
    const std::string path = Path(name);
    EXPECT_THAT(MakeDirectories(path.substr(0, path.find_last_of('/'))),
                IsOk());
    EXPECT_THAT(WriteFileAtomically(path, text), IsOk());
    return path;
  }
  static Json ReportOf(const std::string& library) {
    const auto text = ReadFile(JoinPath(Path(library), "report.json"));
    EXPECT_THAT(text, IsOk());
    return Json::parse(*text);
  }
  // Bytes of a library's file.
  static std::string Bytes(const std::string& library,
                           const std::string& name) {
    const auto bytes = ReadFile(JoinPath(Path(library), name));
    EXPECT_THAT(bytes, IsOk());
    return *bytes;
  }
  // Says of each of a library's files when it was written.
  static std::string WriteTimes(const std::string& library) {
    std::string times;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(Path(library))) {
      // The lock is opened by every import.
      if (entry.path().filename() == "LOCK") continue;
      absl::StrAppend(&times, entry.path().string(), " ",
                      entry.last_write_time().time_since_epoch().count(), "\n");
    }
    return times;
  }
  // A march that no body could do: it jumps five metres within a frame.
  static std::string JumpingJson() {
    return absl::StrReplaceAll(testing::MarchJson(),
                               {{"0.400000000", "5.400000000"}});
  }
  std::unique_ptr<motion::Library> Import(const std::vector<std::string>& files,
                                          const std::string& name) {
    reports_.clear();
    EXPECT_THAT(
        ImportFiles(*character_, files, options_, Path(name), &reports_),
        IsOk());
    auto library = motion::Library::Load(Path(name));
    EXPECT_THAT(library, IsOk());
    return *std::move(library);
  }
  // Height of the lowest body frame, m.
  static double LowestBody(const motion::Library& library, int clip,
                           int64_t frame) {
    const float* position = library.frame(clip, frame).body_position;
    double lowest = INFINITY;
    for (int b = 0; b < library.num_bodies(); ++b) {
      lowest = std::min(lowest, double{position[3 * b + 2]});
    }
    return lowest;
  }

  std::unique_ptr<const character::Character> character_;
  ImportOptions options_;
  std::vector<ClipReport> reports_;
};

TEST_F(ImporterTest, BringsAMarchToTheFloorAndMakesItPhysical) {
  const auto library = Import({Write("march.txt", testing::MarchJson()),
                               Write("floats.txt", testing::MarchJson(0.13))},
                              "march");
  ASSERT_EQ(library->num_clips(), 2);
  for (const ClipReport& report : reports_) {
    const v1::ClipQuality& quality = report.info.quality();
    EXPECT_LT(quality.residual_force_bodyweights(), 0.1) << report.name;
    EXPECT_LT(quality.joint_fit_max_rad(), 0.3) << report.name;
    EXPECT_LT(quality.penetration_max_m(), 0.01) << report.name;
    EXPECT_LT(quality.floating_mean_m(), 0.01) << report.name;
    EXPECT_LT(quality.loop_seam_m(), 0.05) << report.name;
  }
  // A floating capture gives the same motion.
  for (int64_t t = 0; t < library->clip(0).num_frames(); ++t) {
    EXPECT_NEAR(library->frame(0, t).root_position[2],
                library->frame(1, t).root_position[2], 0.005);
  }
}

TEST_F(ImporterTest, BringsALyingBodyToTheFloor) {
  const auto library =
      Import({Write("lying.txt", testing::LyingJson())}, "lying");
  for (int64_t t = 0; t < library->clip(0).num_frames(); ++t) {
    // Limbs are a few centimetres thick.
    EXPECT_LT(LowestBody(*library, 0, t), 0.15) << t;
    EXPECT_GT(LowestBody(*library, 0, t), 0.0) << t;
  }
  EXPECT_LT(reports_[0].info.quality().penetration_max_m(), 0.01);
  EXPECT_EQ(reports_[0].supported_share, 1);
}

TEST_F(ImporterTest, VelocitiesAreThoseOfTheFramesAlsoAcrossTheSeam) {
  const auto library =
      Import({Write("march.txt", testing::MarchJson())}, "velocities");
  const double rate = library->manifest().frames_per_second();
  const int joints = library->num_joints();
  motion::ReferenceFrame before(*library), at(*library), after(*library);
  for (int64_t t = 1; t < 2 * library->clip(0).num_frames(); ++t) {
    before.Load(0, t - 1);
    at.Load(0, t);
    after.Load(0, t + 1);
    for (int j = 0; j < joints; ++j) {
      const double slope =
          (after.view().joint_position[j] - before.view().joint_position[j]) *
          rate / 2;
      EXPECT_NEAR(at.view().joint_velocity[j], slope, 2e-4) << t << " " << j;
    }
    for (int i = 0; i < 3 * library->num_bodies(); ++i) {
      const double slope =
          (after.view().body_position[i] - before.view().body_position[i]) *
          rate / 2;
      // Second order in the spacing of the frames.
      EXPECT_NEAR(at.view().body_linear_velocity[i], slope, 0.15) << t;
    }
    const Eigen::Vector3d turn = motion::CentralAngularVelocity(
        motion::FromWxyz(before.view().root_rotation).normalized(),
        motion::FromWxyz(at.view().root_rotation).normalized(),
        motion::FromWxyz(after.view().root_rotation).normalized(), 1 / rate);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(at.view().root_angular_velocity[i], turn[i], 5e-3) << t;
    }
  }
}

TEST_F(ImporterTest, OneBadFileDoesNotStopTheOthers) {
  const std::string good = testing::MarchJson();
  const std::vector<std::string> files = {
      Write("text.txt", "no clip at all"),
      Write("good.txt", good),
      Write("cut.txt", good.substr(0, good.size() / 2)),
      Write("nan.txt", absl::StrReplaceAll(good, {{"0.890000000", "NaN"}})),
      Path("absent.txt"),
      Path("good.txt"),
  };
  const auto library = Import(files, "mixed");
  EXPECT_EQ(library->num_clips(), 1);
  ASSERT_EQ(reports_.size(), files.size());
  EXPECT_THAT(reports_[0].status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("text.txt: expected JSON")));
  EXPECT_THAT(reports_[1].status, IsOk());
  EXPECT_THAT(reports_[2].status, StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("cut.txt")));
  EXPECT_THAT(reports_[3].status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("nan.txt: expected finite numbers")));
  EXPECT_THAT(reports_[4].status,
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("absent.txt")));
  EXPECT_THAT(reports_[5].status,
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("expected a unique name")));
}

TEST_F(ImporterTest, WritesNothingWhereNoFileIsGood) {
  EXPECT_THAT(ImportFiles(*character_, {Write("bad.txt", "{}")}, options_,
                          Path("none"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));
  EXPECT_FALSE(FileSize(JoinPath(Path("none"), "manifest.json")).ok());
}

TEST_F(ImporterTest, RefusesARateOutOfRange) {
  options_.rate = 0;
  EXPECT_THAT(ImportFiles(*character_, {}, options_, Path("rate"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("rate: expected > 0")));
}

TEST_F(ImporterTest, RejectsWhatNoBodyCouldDoNamingFigureAndLimit) {
  ASSERT_NE(JumpingJson(), testing::MarchJson());
  Import({Write("march.txt", testing::MarchJson()),
          Write("jumps.txt", JumpingJson())},
         "gate");

  EXPECT_THAT(reports_[1].status,
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("jumps.txt"), HasSubstr("limit"))));
  EXPECT_EQ(reports_[1].verdict.status, ClipStatus::kRejected);
  EXPECT_TRUE(reports_[1].measured());
}

TEST_F(ImporterTest, ReportsEveryFileInOrder) {
  options_.provenance = "made by formula";
  Import({Write("march.txt", testing::MarchJson()), Write("bad.txt", "{}"),
          Write("jumps.txt", JumpingJson())},
         "report");

  const Json report = ReportOf("report");

  EXPECT_EQ(report["character"], "humanoid");
  EXPECT_EQ(report["counts"]["rejected"], 2);
  const Json& clips = report["clips"];
  ASSERT_THAT(clips, SizeIs(3));
  EXPECT_EQ(clips[0]["file"], Path("march.txt"));
  EXPECT_EQ(clips[0]["name"], "march");
  EXPECT_NE(clips[0]["status"], "rejected");
  EXPECT_NEAR(clips[0]["seconds"], 1, 1e-6);
  EXPECT_EQ(clips[0]["trial"], "march");
  for (const char* figure :
       {"foot_skate_cm_per_s", "penetration_cm", "floating_cm",
        "joint_limit_violations_percent", "peak_joint_speed_rad_per_s",
        "peak_joint_acceleration_rad_per_s2", "retarget_error_cm",
        "residual_force_bodyweights", "residual_torque_nm",
        "peak_torque_ratio"}) {
    EXPECT_TRUE(clips[0]["figures"][figure].is_number()) << figure;
  }
  EXPECT_EQ(clips[1]["status"], "rejected");
  EXPECT_THAT(clips[1]["reason"].get<std::string>(), HasSubstr("bad.txt"));
  EXPECT_FALSE(clips[1].contains("figures"));
  EXPECT_EQ(clips[2]["status"], "rejected");
  EXPECT_TRUE(clips[2]["figures"].is_object());
}

TEST_F(ImporterTest, ASecondImportOfTheSameFilesDoesNothing) {
  const std::vector<std::string> files = {
      Write("march.txt", testing::MarchJson()), Write("bad.txt", "{}"),
      Write("jumps.txt", JumpingJson())};
  Import(files, "twice");
  const std::string times = WriteTimes("twice");
  bool changed = true;
  options_.changed = &changed;

  Import(files, "twice");

  EXPECT_FALSE(changed);
  EXPECT_EQ(WriteTimes("twice"), times);
  for (const ClipReport& report : reports_) EXPECT_TRUE(report.from_cache);
  EXPECT_EQ(reports_[2].verdict.status, ClipStatus::kRejected);
}

TEST_F(ImporterTest, ReadsAgainOnlyWhatChangedAndDropsWhatIsGone) {
  const std::string march = Write("march.txt", testing::MarchJson());
  const std::string lying = Write("lying.txt", testing::LyingJson());
  const std::string other = Write("other.txt", testing::MarchJson(0.02));
  Import({march, lying, other}, "changes");

  Write("lying.txt", testing::MarchJson(0.05));
  const auto library = Import({march, lying}, "changes");

  EXPECT_TRUE(reports_[0].from_cache);
  EXPECT_FALSE(reports_[1].from_cache);
  EXPECT_EQ(library->num_clips(), 2);
  EXPECT_EQ(library->FindClip("other"), -1);
  // The cache holds two clips of two files each.
  EXPECT_THAT(*ListDirectory(JoinPath(Path("changes"), "cache")), SizeIs(4));
}

TEST_F(ImporterTest, ReadsEverythingAgainWithOtherOptions) {
  const std::vector<std::string> files = {
      Write("march.txt", testing::MarchJson())};
  Import(files, "options");

  options_.rate = 60;
  const auto library = Import(files, "options");

  EXPECT_FALSE(reports_[0].from_cache);
  EXPECT_EQ(library->clip(0).num_frames(), 60);
}

TEST_F(ImporterTest, RepairsALibraryThatWasDamaged) {
  const std::vector<std::string> files = {
      Write("march.txt", testing::MarchJson())};
  Import(files, "damaged");
  const std::string whole = Bytes("damaged", "frames.safetensors");
  const auto entries = ListDirectory(JoinPath(Path("damaged"), "cache"));
  for (const std::string& name : *entries) {
    if (!absl::EndsWith(name, ".clip")) continue;
    Write(JoinPath("damaged/cache", name), "damaged");
  }
  Write("damaged/frames.safetensors", "damaged");

  // What an entry cannot give is imported anew.
  EXPECT_THAT(
      ImportFiles(*character_, files, options_, Path("damaged"), &reports_),
      IsOk());

  EXPECT_EQ(Bytes("damaged", "frames.safetensors"), whole);
}

TEST_F(ImporterTest, GivesTheSameLibraryOnAnyNumberOfThreads) {
  std::vector<std::string> files;
  for (int i = 0; i < 5; ++i) {
    files.push_back(
        Write(absl::StrCat("march", i, ".txt"), testing::MarchJson(0.01 * i)));
  }
  options_.threads = 1;
  Import(files, "one");
  options_.threads = 4;
  Import(files, "four");

  for (const char* name : {"manifest.json", "frames.safetensors"}) {
    EXPECT_EQ(Bytes("one", name), Bytes("four", name)) << name;
  }
}

TEST_F(ImporterTest, TakesPathsWithSpacesAndAnyLetters) {
  const auto library =
      Import({Write("M\u00e4rz 2026/\u6b69\u304f.txt", testing::MarchJson()),
              Write("caf\xE9/caf\xE9.txt", testing::MarchJson(0.01))},
             "\u0431\u0438\u0431\u043b \u00fc");

  EXPECT_EQ(library->clip(0).name(), "\u6b69\u304f");
  EXPECT_EQ(library->clip(1).name(), "caf%E9");
}

TEST_F(ImporterTest, NamesTheSecondClipOfANameAfterItsFolder) {
  const auto library = Import({Write("a/walk.txt", testing::MarchJson()),
                               Write("b/walk.txt", testing::MarchJson(0.01))},
                              "names");

  EXPECT_EQ(library->clip(0).name(), "walk");
  EXPECT_EQ(library->clip(1).name(), "b_walk");
  // One recording, as far as names tell: never split between training and test.
  EXPECT_EQ(library->clip(0).trial(), library->clip(1).trial());
}

TEST_F(ImporterTest, RefusesAFolderThatAnotherImportHolds) {
  const std::string file = Write("march.txt", testing::MarchJson());
  ASSERT_THAT(MakeDirectories(Path("held")), IsOk());
  const auto lock = DirectoryLock::Acquire(Path("held"));
  ASSERT_THAT(lock, IsOk());

  EXPECT_THAT(
      ImportFiles(*character_, {file}, options_, Path("held"), &reports_),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("held")));
}

TEST_F(ImporterTest, KeepsWhatWasFinishedWhenItIsStopped) {
  std::vector<std::string> files;
  for (int i = 0; i < 3; ++i) {
    files.push_back(
        Write(absl::StrCat("march", i, ".txt"), testing::MarchJson(0.01 * i)));
  }
  StopSource stop;
  options_.stop = stop.get_token();
  options_.threads = 1;
  options_.on_progress = [&](const ImportProgress& progress) {
    if (progress.done == 2) stop.request_stop();
  };
  EXPECT_THAT(
      ImportFiles(*character_, files, options_, Path("stopped"), &reports_),
      StatusIs(absl::StatusCode::kCancelled));
  EXPECT_FALSE(FileExists(JoinPath(Path("stopped"), "manifest.json")));

  options_ = {};
  const auto library = Import(files, "stopped");

  EXPECT_EQ(library->num_clips(), 3);
  EXPECT_TRUE(reports_[0].from_cache);
  EXPECT_TRUE(reports_[1].from_cache);
  EXPECT_FALSE(reports_[2].from_cache);
}

TEST_F(ImporterTest, CanReportWithoutWritingALibrary) {
  options_.report_only = true;

  EXPECT_THAT(
      ImportFiles(*character_, {Write("march.txt", testing::MarchJson())},
                  options_, Path("report"), &reports_),
      IsOk());

  EXPECT_THAT(ReportOf("report")["clips"], SizeIs(1));
  EXPECT_FALSE(FileExists(JoinPath(Path("report"), "manifest.json")));
}

TEST_F(ImporterTest, AddsMirrorImagesUnderNamesOfTheirOwn) {
  options_.edits.mirror = true;
  const auto library = Import({Write("march.txt", testing::MarchJson()),
                               Write("lying_mirror.txt", testing::LyingJson()),
                               Write("lying.txt", testing::LyingJson())},
                              "mirrored");

  // The mirror image of "lying" finds its name taken.
  ASSERT_THAT(reports_, SizeIs(6));
  EXPECT_THAT(reports_[5].status,
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("found a file called lying_mirror")));
  EXPECT_EQ(library->num_clips(), 5);
  EXPECT_EQ(library->clip(1).name(), "march_mirror");
  EXPECT_EQ(library->clip(1).mirror_of(), "march");
  EXPECT_EQ(library->clip(1).trial(), "march");
  EXPECT_EQ(library->clip(0).mirror_of(), "");
  // It walks along x too, and sways to the other side.
  const int64_t last = library->clip(0).num_frames() - 1;
  EXPECT_NEAR(library->frame(1, last).root_position[0],
              library->frame(0, last).root_position[0], 1e-4);
  EXPECT_NEAR(library->frame(1, last).root_position[1],
              -library->frame(0, last).root_position[1], 1e-4);
}

TEST_F(ImporterTest, TellsOfEveryFileOnce) {
  std::vector<int> done;
  options_.on_progress = [&](const ImportProgress& progress) {
    done.push_back(progress.done);
    EXPECT_EQ(progress.total, 2);
    EXPECT_THAT(progress.last->file, Not(IsEmpty()));
  };
  Import({Write("march.txt", testing::MarchJson()), Write("bad.txt", "{}")},
         "telling");
  EXPECT_EQ(done, std::vector<int>({1, 2}));
}

TEST_F(ImporterTest, RecordedClipsKeepTheirQuality) {
  const std::vector<std::string> files = testing::RecordedClips();
  if (files.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
  Import(files, "recorded");
  for (const ClipReport& report : reports_) {
    EXPECT_THAT(report.status, IsOk());
    const v1::ClipQuality& quality = report.info.quality();
    EXPECT_LT(quality.residual_force_bodyweights(), 0.25) << report.name;
    EXPECT_LT(quality.penetration_max_m(), 0.02) << report.name;
    EXPECT_LT(quality.floating_mean_m(), 0.01) << report.name;
    EXPECT_LT(quality.joint_fit_mean_rad(), 0.1) << report.name;
  }
}

}  // namespace
}  // namespace sinew::import
