#include "sim/import/blend_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "common/workspace_files.h"
#include "sim/import/blend_clips.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(BlendListTest, ReadsPairsInOrder) {
  const std::string path = WriteTestFile("blends.textproto", R"(
    blends {
      first: "a/step.bvh" second: "/all/stand.bvh" gap_s: 0.8
      first_from_s: 2 second_from_s: 4.5 second_to_s: 7
    }
    blends { first: "b.bvh" second: "c.bvh" first_to_s: 3 name: "b-c.2" })");

  const auto blends = ReadBlendList(path, "/");

  ASSERT_THAT(blends, IsOk());
  ASSERT_THAT(*blends, SizeIs(2));
  const BlendedFiles& one = blends->at(0);
  EXPECT_EQ(one.first, "/a/step.bvh");
  EXPECT_EQ(one.second, "/all/stand.bvh");
  EXPECT_EQ(one.blend.gap_s, 0.8);
  EXPECT_EQ(one.blend.first.from_s, 2);
  EXPECT_EQ(one.blend.first.to_s, std::numeric_limits<double>::infinity());
  EXPECT_EQ(one.blend.second.from_s, 4.5);
  EXPECT_EQ(one.blend.second.to_s, 7);
  const BlendedFiles& other = blends->at(1);
  EXPECT_EQ(other.second, "/c.bvh");
  EXPECT_EQ(other.blend.gap_s, BlendOptions().gap_s);
  EXPECT_EQ(other.blend.first.from_s, 0);
  EXPECT_EQ(other.blend.first.to_s, 3);
  EXPECT_EQ(one.name, "");
  EXPECT_EQ(other.name, "b-c.2");
}

TEST(BlendListTest, PathsBeginAtTheListsFolderUnlessTold) {
  const std::string path = WriteTestFile(
      "blends.textproto", "blends { first: \"b.bvh\" second: \"c.bvh\" }");

  const auto blends = ReadBlendList(path, "");

  ASSERT_THAT(blends, IsOk());
  EXPECT_EQ(blends->at(0).first, TestPath("b.bvh"));
}

constexpr char kGood[] = "blends { first: \"a\" second: \"b\" } ";

// Refused with the list's name and what was found.
void ExpectRefused(const std::string& text, const std::string& found) {
  const std::string path = WriteTestFile("blends.textproto", text);
  EXPECT_THAT(ReadBlendList(path, ""),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("blends.textproto"), HasSubstr(found))))
      << text;
}

TEST(BlendListTest, RefusesWhatIsNoListOfPairs) {
  ExpectRefused("", "blends: expected at least one, found none");
  ExpectRefused("blends { first: \"a\" third: \"b\" }", "\"third\"");
  ExpectRefused(kGood + std::string("blends { first: \"a\" }"),
                "pair 2: second: expected a path, found none");
  ExpectRefused("blends { second: \"a\" }",
                "pair 1: first: expected a path, found none");
  EXPECT_THAT(ReadBlendList(TestPath("absent"), ""),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(
      ReadBlendList(WriteTestFile("blends.textproto", kGood), TestPath("not")),
      StatusIs(
          absl::StatusCode::kInvalidArgument,
          HasSubstr("root: expected a folder, found \"" + TestPath("not"))));
}

TEST(BlendListTest, RefusesNumbersThatAreOutOfRange) {
  for (const auto& [fields, found] : {
           std::pair("gap_s: 0", "pair 1: gap_s: "),
           std::pair("gap_s: 3", "pair 1: gap_s: "),
           std::pair("gap_s: nan", "pair 1: gap_s: "),
           std::pair("first_from_s: -1", "first_from_s: expected >= 0"),
           std::pair("second_from_s: inf", "second_from_s: expected >= 0"),
           std::pair("first_to_s: inf", "first_to_s: expected more than 0"),
           std::pair("second_from_s: 2 second_to_s: 2",
                     "second_to_s: expected more than 2, found 2"),
       }) {
    ExpectRefused(
        absl::StrCat("blends { first: \"a\" second: \"b\" ", fields, " }"),
        found);
  }
}

TEST(BlendListTest, WantsANameForEachPair) {
  ExpectRefused(kGood + std::string(kGood),
                "pair 2: name: expected one that no other pair has, found "
                "\"a_to_b\" (pair 1)");
  ExpectRefused("blends { first: \"a\" second: \"b\" name: \"c/d\" }",
                "pair 1: name: expected letters, digits, _, - and .");
}

TEST(BlendListTest, ReadsTheListsOfTheProject) {
  const auto path = FindWorkspaceFile("docs/lists/stands.textproto");
  ASSERT_THAT(path, IsOk());

  const auto blends = ReadBlendList(*path, "");

  ASSERT_THAT(blends, IsOk());
  EXPECT_THAT(*blends, SizeIs(28));
}

}  // namespace
}  // namespace sinew::import
