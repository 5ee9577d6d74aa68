#include "sim/import/formats/text_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/import/formats/unique_names.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

std::vector<std::pair<int, std::string>> AllLines(absl::string_view bytes) {
  std::vector<std::pair<int, std::string>> all;
  TextLines lines(bytes);
  while (lines.Next()) {
    all.emplace_back(lines.number(), std::string(lines.text()));
  }
  return all;
}

TEST(TextLines, EndWithAnyOfThreeEndsAndKeepTheirNumbers) {
  EXPECT_THAT(AllLines("\xef\xbb\xbf"
                       "a\r\n b\t\n\nc\rd"),
              ElementsAre(Pair(1, "a"), Pair(2, "b"), Pair(3, ""), Pair(4, "c"),
                          Pair(5, "d")));
  EXPECT_THAT(AllLines(""), ElementsAre());
  EXPECT_THAT(AllLines("\n"), ElementsAre(Pair(1, "")));
}

TEST(TextLines, GiveTheirWordsOneByOne) {
  absl::string_view text = " one\t two ";

  EXPECT_EQ(TakeWord(&text), "one");
  EXPECT_EQ(TakeWord(&text), "two");
  EXPECT_EQ(TakeWord(&text), "");
}

TEST(ParseNumber, TakesFiniteNumbersOfASensibleSize) {
  EXPECT_THAT(ParseNumber("-2.20695e-032"), IsOkAndHolds(-2.20695e-32));
  EXPECT_THAT(ParseNumber(".5"), IsOkAndHolds(0.5));
  EXPECT_THAT(ParseNumber("+7"), IsOkAndHolds(7));
}

TEST(ParseNumber, SaysWhatItExpectedAndFound) {
  for (const char* word : {"nan", "inf", "-1e999", "1e300", "2e9"}) {
    EXPECT_THAT(ParseNumber(word),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("expected a finite number of at most 1e+09 "
                                   "in size, found \"")));
  }
  for (const char* word : {"", "1,5", "walk", "1.2.3", "--1"}) {
    EXPECT_THAT(ParseNumber(word), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("expected a number")));
  }
}

TEST(Quoted, EscapesAndShortensWhatAFileHolds) {
  EXPECT_EQ(Quoted("a\xff\n"), "\"a\\xff\\n\"");
  EXPECT_EQ(Quoted(std::string(100, 'x')),
            "\"" + std::string(40, 'x') + "...\"");
}

TEST(ParseName, KeepsUtf8AndEscapesOtherBytes) {
  EXPECT_THAT(ParseName(" mixamorig:T\xc3\xaate "),
              IsOkAndHolds("mixamorig:T\xc3\xaate"));
  EXPECT_THAT(ParseName("T\xeate"), IsOkAndHolds("T\\xeate"));
  EXPECT_THAT(ParseName("\xed\xa0\x80"), IsOkAndHolds("\\xed\\xa0\\x80"));
  EXPECT_THAT(ParseName("a\x01"), IsOkAndHolds("a\\x01"));
}

TEST(ParseName, RefusesNoneAndTooLong) {
  EXPECT_THAT(ParseName(" "), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(ParseName(std::string(129, 'x')),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a name of 1 to 128 bytes")));
}

TEST(UniqueNames, NumbersWhatItHasSeen) {
  UniqueNames names;

  EXPECT_EQ(names.Take("Hand_2"), "Hand_2");
  EXPECT_EQ(names.Take("Hand"), "Hand");
  EXPECT_EQ(names.Take("Hand"), "Hand_3");
}

TEST(CheckFileSize, NamesTheFileAndBothSizes) {
  EXPECT_THAT(CheckFileSize("abc", 3, "a.bvh"), IsOk());
  EXPECT_THAT(CheckFileSize("abcd", 3, "a.bvh"),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "a.bvh: expected at most 3 bytes, found 4"));
}

TEST(CheckRotations, NamesTheFileAndTheMost) {
  EXPECT_THAT(CheckRotations(2, 3, 6, "a.bvh"), IsOk());
  EXPECT_THAT(CheckRotations(2, 4, 6, "a.bvh"),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("a.bvh: expected at most 6 joints times")));
}

}  // namespace
}  // namespace sinew::import
