#include "sim/import/formats/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/npz_writer.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MakeNpy;
using testing::MakeNpyText;

std::vector<double> Numbers(const NpyArray& array) {
  std::vector<double> numbers;
  for (int64_t i = 0; i < array.count(); ++i) {
    numbers.push_back(array.Number(i));
  }
  return numbers;
}

TEST(Npy, ReadsNumbersOfEveryType) {
  for (const char* type : {"<f4", "<f8", ">f4", ">f8", "<i4", ">i8", "|u1"}) {
    const auto array =
        NpyArray::Parse(MakeNpy(type, "(2, 2)", {1, 2, 3, 40}), "a.npy");

    ASSERT_THAT(array, IsOk()) << type;
    EXPECT_THAT(array->shape(), ElementsAre(2, 2));
    EXPECT_THAT(Numbers(*array), ElementsAre(1, 2, 3, 40)) << type;
  }
}

TEST(Npy, ReadsHalfPrecision) {
  // 0x3C00 is 1, 0xC100 is -2.5.
  const std::string data("\x00\x3C\x00\xC1", 4);
  const auto array = NpyArray::Parse(MakeNpy("<f2", false, "(2,)", data), "a");

  ASSERT_THAT(array, IsOk());
  EXPECT_THAT(Numbers(*array), ElementsAre(1, -2.5));
}

TEST(Npy, GivesFortranOrderInCOrder) {
  const std::string data("\x00\x10\x01\x11\x02\x12", 6);
  const auto array = NpyArray::Parse(MakeNpy("|u1", true, "(2, 3)", data), "a");

  ASSERT_THAT(array, IsOk());
  EXPECT_THAT(Numbers(*array), ElementsAre(0, 1, 2, 16, 17, 18));
}

TEST(Npy, ReadsOneElementWithoutDimensions) {
  const auto array = NpyArray::Parse(MakeNpy("<f8", "()", {59.94}), "a");

  ASSERT_THAT(array, IsOk());
  EXPECT_THAT(Numbers(*array), ElementsAre(59.94));
}

TEST(Npy, ReadsText) {
  const auto unicode = NpyArray::Parse(MakeNpyText("neutral"), "a");
  ASSERT_THAT(unicode, IsOk());
  EXPECT_THAT(unicode->Text("a"), IsOkAndHolds("neutral"));

  const auto bytes = NpyArray::Parse(
      MakeNpy("|S6", false, "(1,)", absl::string_view("male\0\0", 6)), "a");
  ASSERT_THAT(bytes, IsOk());
  EXPECT_THAT(bytes->Text("a"), IsOkAndHolds("male"));

  const std::string umlaut("\xFC\0\0\0", 4);
  const auto latin = NpyArray::Parse(MakeNpy("<U1", false, "()", umlaut), "a");
  ASSERT_THAT(latin, IsOk());
  EXPECT_THAT(latin->Text("a"), IsOkAndHolds("\xC3\xBC"));
}

struct BadArray {
  std::string bytes;
  std::string expected;
};

class NpyError : public ::testing::TestWithParam<BadArray> {};

TEST_P(NpyError, NamesSourceExpectedAndFound) {
  EXPECT_THAT(NpyArray::Parse(GetParam().bytes, "b.npz: poses"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("b.npz: poses: "), HasSubstr("expected"),
                             HasSubstr(GetParam().expected))));
}

std::string Header(const std::string& text) {
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes.push_back(static_cast<char>(text.size()));
  bytes.push_back('\0');
  return bytes + text;
}

INSTANTIATE_TEST_SUITE_P(
    Bytes, NpyError,
    ::testing::Values(
        BadArray{"", "found bytes that begin with \"\""},
        BadArray{"PK\x03\x04 and more", "found bytes that begin with \"PK"},
        BadArray{std::string("\x93NUMPY\x04\x00\x00\x00", 10), "version 4"},
        BadArray{Header("").substr(0, 10) + "{", "found \"\""},
        BadArray{std::string("\x93NUMPY\x01\x00\x50\x00{", 11),
                 "a truncated header"},
        BadArray{std::string("\x93NUMPY\x01\x00\xFF\xFF{", 11),
                 "a header of 65535 bytes"}));

INSTANTIATE_TEST_SUITE_P(
    Headers, NpyError,
    ::testing::Values(
        BadArray{MakeNpy("|O", false, "(3,)", "pickle"),
                 "found pickled Python objects, type \"|O\""},
        BadArray{MakeNpy("<c8", false, "(1,)", "12345678"), "type \"<c8\""},
        BadArray{MakeNpy("<f3", false, "(1,)", "123"), "type \"<f3\""},
        BadArray{MakeNpy("<i99999999999", false, "(1,)", ""), "type"},
        BadArray{MakeNpy("<f4", false, "(1, 1, 1, 1, 1)", "1234"),
                 "at most 4 dimensions"},
        BadArray{MakeNpy("<f4", false, "(-1,)", ""), "a size, found \"-1"},
        BadArray{MakeNpy("<f4", false, "(2,)", "1234"),
                 "bytes for float32 (2), found"},
        BadArray{Header("{'descr': '<f4', 'shape': ()}"),
                 "the keys descr, fortran_order and shape"},
        BadArray{Header("{'descr': '<f4', 'descr': '<f4'}"),
                 "each of the keys descr, fortran_order and shape once"},
        BadArray{Header("{'descr': [('a', '<f4')]}"),
                 "an array of numbers or text, found \"[("},
        BadArray{Header("{'evil': 1}"), "each of the keys"},
        BadArray{Header("{'descr': '<f4', 'fortran_order': 1}"),
                 "True or False, found \"1}\""}));

TEST(Npy, RefusesShapesThatNoMemoryHolds) {
  EXPECT_THAT(
      NpyArray::Parse(
          MakeNpy("<f8", false, "(1000000000, 1000000000, 1000000000)", ""),
          "b.npz: poses"),
      StatusIs(absl::StatusCode::kResourceExhausted,
               HasSubstr("expected an array of at most 1073741824 bytes, "
                         "found float64 (1000000000, ")));
  // Text of no letters takes no bytes, however many there are.
  EXPECT_THAT(
      NpyArray::Parse(
          MakeNpy("<U0", false, "(1000000000, 1000000000, 1000000000)", ""),
          "b.npz: gender"),
      StatusIs(absl::StatusCode::kResourceExhausted,
               HasSubstr("expected an array of at most")));
}

}  // namespace
}  // namespace sinew::import
