#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "nlohmann/json.hpp"
#include "sim/import/clip_report.h"
#include "sim/import/importer.h"
#include "sim/import/testing/import_fixture.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using Json = nlohmann::json;

class ImporterBlendTest : public testing::ImportFixture {
 protected:
  // Of two files of the same march, which it joins to two cycles of it.
  BlendedFiles Marches() const {
    return {.first = march_,
            .second = other_,
            .blend = {.gap_s = 0.2, .first = {.from_s = 0, .to_s = 0.8}}};
  }

  const std::string march_ = WriteTestFile("march.txt", testing::MarchJson());
  const std::string other_ =
      WriteTestFile("other.txt", testing::MarchJson(0.05));
};

TEST_F(ImporterBlendTest, JoinsTwoFilesIntoOneClipOfTheLibrary) {
  options_.blends = {Marches()};

  const auto library = Import({}, "blend");

  ASSERT_EQ(library->num_clips(), 1);
  const v1::ClipInfo& clip = library->clip(0);
  EXPECT_EQ(clip.name(), "march_to_other");
  EXPECT_EQ(clip.num_frames(), 60);
  EXPECT_FALSE(clip.loops());
  EXPECT_EQ(clip.source_file(), "march.txt");
  EXPECT_EQ(clip.trial(), "march");
  EXPECT_EQ(clip.blend().source_file(), "other.txt");
  EXPECT_EQ(clip.blend().trial(), "other");
  EXPECT_EQ(clip.blend().source().format(), "deepmimic");
  EXPECT_EQ(clip.blend().source().map(), "deepmimic");
  EXPECT_NEAR(clip.blend().gap_s(), 0.2, 1e-9);
  EXPECT_NE(clip.blend().source_sha256(), clip.source_sha256());
  // On along x: two cycles of 0.8 m, less the last frame.
  EXPECT_NEAR(library->frame(0, 59).root_position[0] -
                  library->frame(0, 0).root_position[0],
              1.6 * 59 / 60, 0.3);
  ASSERT_THAT(reports_, SizeIs(1));
  EXPECT_EQ(reports_[0].file, absl::StrCat(march_, " + ", other_));
  const Json report = ReportOf("blend")["clips"][0];
  EXPECT_EQ(report["blend"]["file"], "other.txt");
  EXPECT_TRUE(report["figures"].is_object());
}

TEST_F(ImporterBlendTest, ComesBehindTheFilesAndHasAMirrorImage) {
  options_.blends = {Marches()};
  options_.edits.mirror = true;

  const auto library = Import({other_}, "mirrored");

  ASSERT_EQ(library->num_clips(), 4);
  EXPECT_EQ(library->clip(0).name(), "other");
  EXPECT_FALSE(library->clip(0).has_blend());
  EXPECT_EQ(library->clip(2).name(), "march_to_other");
  EXPECT_EQ(library->clip(3).name(), "march_to_other_mirror");
  EXPECT_EQ(library->clip(3).mirror_of(), "march_to_other");
  EXPECT_NEAR(library->frame(3, 59).root_position[1],
              -library->frame(2, 59).root_position[1], 1e-4);
}

TEST_F(ImporterBlendTest, IsMadeAnewOnlyWhereSomethingChanged) {
  bool changed = false;
  options_.changed = &changed;
  options_.blends = {Marches()};
  Import({}, "cache");

  Import({}, "cache");
  EXPECT_FALSE(changed);
  EXPECT_TRUE(reports_[0].from_cache);

  options_.blends[0].blend.gap_s = 0.3;
  EXPECT_EQ(Import({}, "cache")->clip(0).num_frames(), 63);
  EXPECT_FALSE(reports_[0].from_cache);

  WriteTestFile("other.txt", testing::MarchJson(0.06));
  Import({}, "cache");
  EXPECT_FALSE(reports_[0].from_cache);
}

TEST_F(ImporterBlendTest, ANameThatAFileHasAlreadyGetsTheFolderInFront) {
  options_.blends = {Marches()};

  const auto library = Import(
      {WriteTestFile("march_to_other.txt", testing::MarchJson(0.01))}, "names");

  ASSERT_EQ(library->num_clips(), 2);
  EXPECT_EQ(library->clip(0).name(), "march_to_other");
  EXPECT_THAT(library->clip(1).name(), HasSubstr("_march_to_other"));
}

TEST_F(ImporterBlendTest, SaysWhichOfTheFilesIsBadAndGoesOn) {
  const std::string bad = WriteTestFile("bad.txt", "{}");
  BlendedFiles short_first = Marches();
  short_first.blend.first = {.from_s = 5, .to_s = 6};
  options_.blends = {{.first = march_, .second = TestPath("absent.txt")},
                     {.first = bad, .second = march_},
                     short_first};

  Import({march_}, "bad");

  ASSERT_THAT(reports_, SizeIs(4));
  EXPECT_THAT(reports_[0].status, IsOk());
  EXPECT_THAT(reports_[1].status,
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("absent.txt")));
  EXPECT_EQ(reports_[1].name, "march_to_absent");
  EXPECT_THAT(reports_[2].status, StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("bad.txt")));
  EXPECT_THAT(reports_[3].status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("march.txt + "), HasSubstr("trim"))));
}

TEST_F(ImporterBlendTest, RefusesAGapOutOfRange) {
  options_.blends = {Marches()};
  options_.blends[0].blend.gap_s = 11;

  EXPECT_THAT(
      ImportFiles(*character_, {}, options_, TestPath("gap"), &reports_),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("gap of more than 0 and at most 2 s, found 11")));
}

}  // namespace
}  // namespace sinew::import
