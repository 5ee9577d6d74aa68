#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "sim/import/clip_report.h"
#include "sim/import/importer.h"
#include "sim/import/quality_gate.h"
#include "sim/import/testing/import_fixture.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class ImporterCacheTest : public testing::ImportFixture {};

TEST_F(ImporterCacheTest, ASecondImportOfTheSameFilesDoesNothing) {
  const std::vector<std::string> files = {
      WriteTestFile("march.txt", testing::MarchJson()),
      WriteTestFile("bad.txt", "{}"),
      WriteTestFile("jumps.txt", JumpingJson())};
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

TEST_F(ImporterCacheTest, ReadsAgainOnlyWhatChangedAndDropsWhatIsGone) {
  const std::string march = WriteTestFile("march.txt", testing::MarchJson());
  const std::string lying = WriteTestFile("lying.txt", testing::LyingJson());
  const std::string other =
      WriteTestFile("other.txt", testing::MarchJson(0.02));
  Import({march, lying, other}, "changes");

  WriteTestFile("lying.txt", testing::MarchJson(0.05));
  const auto library = Import({march, lying}, "changes");

  EXPECT_TRUE(reports_[0].from_cache);
  EXPECT_FALSE(reports_[1].from_cache);
  EXPECT_EQ(library->num_clips(), 2);
  EXPECT_EQ(library->FindClip("other"), -1);
  // The cache holds two clips of two files each.
  EXPECT_THAT(*ListDirectory(JoinPath(TestPath("changes"), "cache")),
              SizeIs(4));
}

TEST_F(ImporterCacheTest, KnowsAClipUnderAnotherNameOfItsKind) {
  Import({WriteTestFile("first.TXT", testing::MarchJson()),
          WriteTestFile("plain", testing::LyingJson())},
         "renamed");

  const auto library =
      Import({WriteTestFile("second.txt", testing::MarchJson()),
              WriteTestFile("folder.2/bare", testing::LyingJson())},
             "renamed");

  for (const ClipReport& report : reports_) {
    EXPECT_TRUE(report.from_cache) << report.name;
  }
  EXPECT_EQ(library->clip(0).name(), "second");
  EXPECT_EQ(library->clip(1).name(), "bare");
}

TEST_F(ImporterCacheTest, ReadsEverythingAgainWithOtherOptions) {
  const std::vector<std::string> files = {
      WriteTestFile("march.txt", testing::MarchJson())};
  Import(files, "options");

  options_.rate = 60;
  const auto library = Import(files, "options");

  EXPECT_FALSE(reports_[0].from_cache);
  EXPECT_EQ(library->clip(0).num_frames(), 60);
}

TEST_F(ImporterCacheTest, RepairsALibraryThatWasDamaged) {
  const std::vector<std::string> files = {
      WriteTestFile("march.txt", testing::MarchJson())};
  Import(files, "damaged");
  const std::string whole = Bytes("damaged", "frames.safetensors");
  const auto entries = ListDirectory(JoinPath(TestPath("damaged"), "cache"));
  for (const std::string& name : *entries) {
    if (!absl::EndsWith(name, ".clip")) continue;
    WriteTestFile(JoinPath("damaged/cache", name), "damaged");
  }
  WriteTestFile("damaged/frames.safetensors", "damaged");

  // What an entry cannot give is imported anew.
  EXPECT_THAT(
      ImportFiles(*character_, files, options_, TestPath("damaged"), &reports_),
      IsOk());

  EXPECT_EQ(Bytes("damaged", "frames.safetensors"), whole);
}

TEST_F(ImporterCacheTest, RepairsFramesOfWhichAByteWasAltered) {
  const std::vector<std::string> files = {
      WriteTestFile("march.txt", testing::MarchJson())};
  Import(files, "altered");
  const std::string whole = Bytes("altered", "frames.safetensors");
  std::string altered = whole;
  altered.back() ^= 1;
  WriteTestFile("altered/frames.safetensors", altered);
  bool changed = false;
  options_.changed = &changed;

  EXPECT_THAT(
      ImportFiles(*character_, files, options_, TestPath("altered"), &reports_),
      IsOk());

  EXPECT_TRUE(changed);
  EXPECT_EQ(Bytes("altered", "frames.safetensors"), whole);
}

TEST_F(ImporterCacheTest, KeepsWhatWasFinishedWhenItIsStopped) {
  std::vector<std::string> files;
  for (int i = 0; i < 3; ++i) {
    files.push_back(WriteTestFile(absl::StrCat("march", i, ".txt"),
                                  testing::MarchJson(0.01 * i)));
  }
  StopSource stop;
  options_.stop = stop.get_token();
  options_.threads = 1;
  options_.on_progress = [&](const ImportProgress& progress) {
    if (progress.done == 2) stop.request_stop();
  };
  EXPECT_THAT(
      ImportFiles(*character_, files, options_, TestPath("stopped"), &reports_),
      StatusIs(absl::StatusCode::kCancelled));
  EXPECT_FALSE(FileExists(JoinPath(TestPath("stopped"), "manifest.json")));

  options_ = {};
  const auto library = Import(files, "stopped");

  EXPECT_EQ(library->num_clips(), 3);
  EXPECT_TRUE(reports_[0].from_cache);
  EXPECT_TRUE(reports_[1].from_cache);
  EXPECT_FALSE(reports_[2].from_cache);
}

TEST_F(ImporterCacheTest, FindsAFlippedByteOfACachedClip) {
  const std::vector<std::string> files = {
      WriteTestFile("march.txt", testing::MarchJson())};
  Import(files, "flipped");
  const std::string whole = Bytes("flipped", "frames.safetensors");
  const auto entries = ListDirectory(JoinPath(TestPath("flipped"), "cache"));
  ASSERT_THAT(entries, IsOk());
  for (const std::string& name : *entries) {
    if (!absl::EndsWith(name, ".clip")) continue;
    std::string clip = Bytes("flipped/cache", name);
    clip.back() ^= 1;
    WriteTestFile(JoinPath("flipped/cache", name), clip);
  }
  // The library has to be written again, from that entry.
  WriteTestFile("flipped/frames.safetensors", "damaged");

  EXPECT_THAT(
      ImportFiles(*character_, files, options_, TestPath("flipped"), &reports_),
      StatusIs(absl::StatusCode::kDataLoss, HasSubstr("altered")));

  Import(files, "flipped");
  EXPECT_FALSE(reports_[0].from_cache);
  EXPECT_EQ(Bytes("flipped", "frames.safetensors"), whole);
}

}  // namespace
}  // namespace sinew::import
