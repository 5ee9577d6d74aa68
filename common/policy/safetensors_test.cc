#include "common/policy/safetensors.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

TensorMap SmallMap() {
  TensorMap tensors;
  tensors["b/weight"] = HostTensor::Float32({2, 3}, {0, 1, 2, 3, 4, 5});
  tensors["a"] = HostTensor::Float64({2}, {-1.5, 2.5});
  tensors["scalar"] = HostTensor::Float32({}, {7.0f});
  tensors["empty"] = HostTensor::Float32({0, 4}, {});
  HostTensor bytes;
  bytes.dtype = v1::DATA_TYPE_UINT8;
  bytes.shape = {3};
  bytes.data = "xyz";
  tensors["zz"] = bytes;
  return tensors;
}

// A file with this header text, and `data` zero bytes after it.
std::string File(absl::string_view header, size_t data) {
  std::string bytes(8, '\0');
  const uint64_t length = header.size();
  std::memcpy(bytes.data(), &length, 8);
  return absl::StrCat(bytes, header, std::string(data, '\0'));
}

void ExpectError(absl::string_view header, size_t data,
                 absl::string_view message) {
  EXPECT_THAT(ParseSafetensors(File(header, data), "w.safetensors"),
              StatusIs(kInvalid, absl::StrCat("w.safetensors: ", message)))
      << header;
}

TEST(Safetensors, ReadsBackWhatItWrote) {
  const TensorMap tensors = SmallMap();

  const auto read =
      ParseSafetensors(SerializeSafetensors(tensors, {{"k", "v"}}), "memory");

  ASSERT_THAT(read, IsOk());
  ASSERT_EQ(read->size(), tensors.size());
  for (const auto& [name, tensor] : tensors) {
    EXPECT_EQ(read->at(name).dtype, tensor.dtype) << name;
    EXPECT_EQ(read->at(name).shape, tensor.shape) << name;
    EXPECT_EQ(read->at(name).data, tensor.data) << name;
  }
  EXPECT_THAT(read->at("b/weight").float32(), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(read->at("a").float64(), ElementsAre(-1.5, 2.5));
}

TEST(Safetensors, WritesTheGoldenBytes) {
  TensorMap tensors;
  tensors["w"] = HostTensor::Float32({1, 2}, {1.0f, -2.0f});
  tensors["b"] = HostTensor::Zeros({1});

  // The header's length, its text padded with spaces to eights, the data.
  const std::string header =
      R"({"b":{"dtype":"F32","shape":[1],"data_offsets":[0,4]},)"
      R"("w":{"dtype":"F32","shape":[1,2],"data_offsets":[4,12]}})";
  const std::string padded =
      header + std::string((8 - header.size() % 8) % 8, ' ');
  std::string expected(8, '\0');
  expected[0] = static_cast<char>(padded.size());
  expected += padded;
  expected += absl::HexStringToBytes(
      "00000000"
      "0000803f"
      "000000c0");
  EXPECT_EQ(SerializeSafetensors(tensors), expected);
}

TEST(Safetensors, WritesMetadataFirst) {
  const std::string bytes = SerializeSafetensors({}, {{"b", "2"}, {"a", "1"}});

  EXPECT_THAT(bytes, HasSubstr(R"({"__metadata__":{"a":"1","b":"2"}})"));
}

TEST(Safetensors, LocatesDataWithinTheFile) {
  const std::string bytes = SerializeSafetensors(SmallMap());

  const auto locations = LocateSafetensors(bytes, "memory");

  ASSERT_THAT(locations, IsOk());
  const TensorLocation at = locations->at("b/weight");
  EXPECT_EQ(at.length, 24);
  EXPECT_EQ(bytes.substr(at.offset, at.length), SmallMap()["b/weight"].data);
  EXPECT_EQ(locations->at("empty").length, 0);
  EXPECT_EQ(locations->at("zz").offset + 3, bytes.size());
}

TEST(Safetensors, AcceptsEntriesInAnyOrderAndAnEmptyMap) {
  const auto read = ParseSafetensors(
      File(R"({"b":{"data_offsets":[4,8],"dtype":"F32","shape":[1]},)"
           R"("a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}  )",
           8),
      "memory");

  EXPECT_THAT(read, IsOk());
  EXPECT_THAT(ParseSafetensors(File("{}", 0), "memory"), IsOk());
}

TEST(Safetensors, SaysWhatIsWrongWithAHeader) {
  ExpectError("", 0, "no valid JSON at byte 1 of the header");
  ExpectError("{", 0, "no valid JSON at byte 2 of the header");
  ExpectError("{} x", 0, "no valid JSON at byte 4 of the header");
  ExpectError("[]", 0, "expected one object of tensors, found an array");
  ExpectError("7", 0, "expected one object of tensors, found the number 7");
  ExpectError(R"({"a":3})", 0,
              "tensor \"a\": expected an object with dtype, shape and "
              "data_offsets, found the number 3");
  ExpectError(R"({"a":{}})", 0, "tensor \"a\": field dtype is missing");
  ExpectError(R"({"a":{"dtype":"F32"}})", 0,
              "tensor \"a\": field shape is missing");
  ExpectError(R"({"a":{"dtype":"F32","shape":[]}})", 0,
              "tensor \"a\": field data_offsets is missing");
  ExpectError(R"({"a":{"dtype":"F16"}})", 0,
              "tensor \"a\": expected dtype F32, F64, I32, I64 or U8, found "
              "\"F16\"");
  ExpectError(R"({"a":{"dtype":"F32","dtype":"F32"}})", 0,
              "tensor \"a\": field dtype appears twice");
  ExpectError(R"({"a":{"extra":1}})", 0,
              "tensor \"a\": expected fields dtype, shape and data_offsets, "
              "found \"extra\"");
  ExpectError(R"({"":{}})", 0, "a tensor has an empty name");
  ExpectError(R"({"__metadata__":{"a":1}})", 0,
              "expected __metadata__ as an object of strings, found the "
              "number 1");
  ExpectError(R"({"a":{"shape":[[1]]}})", 0,
              "tensor \"a\": expected shape as an array of integers >= 0, "
              "found an array");
  ExpectError(R"({"a":{"shape":[-1]}})", 0,
              "tensor \"a\": expected shape as an array of integers >= 0, "
              "found the number -1");
  ExpectError(R"({"a":{"shape":[1.5]}})", 0,
              "tensor \"a\": expected shape as an array of integers >= 0, "
              "found the number 1.5");
  ExpectError(R"({"a":{"shape":[1,1,1,1,1,1,1,1,1]}})", 0,
              "tensor \"a\": expected at most 8 extents, found more");
}

TEST(Safetensors, SaysWhatIsWrongWithOffsets) {
  const auto entry = [](absl::string_view name, absl::string_view shape,
                        absl::string_view offsets) {
    return absl::StrCat("\"", name, R"(":{"dtype":"F32","shape":[)", shape,
                        R"(],"data_offsets":[)", offsets, "]}");
  };
  const auto header = [](auto... entries) {
    return absl::StrCat("{", absl::StrJoin({std::string(entries)...}, ","),
                        "}");
  };
  ExpectError(header(entry("a", "1", "0")), 4,
              "tensor \"a\": expected two data_offsets, found 1");
  ExpectError(header(entry("a", "1", "4,8")), 8,
              "tensor \"a\": expected data_offsets from 0 on within 8 bytes "
              "of data, found [4, 8]");
  ExpectError(header(entry("a", "1", "0,4"), entry("b", "2", "2,10")), 10,
              "tensor \"b\": expected data_offsets from 4 on within 10 bytes "
              "of data, found [2, 10]");
  ExpectError(header(entry("a", "2", "0,8")), 4,
              "tensor \"a\": expected data_offsets from 0 on within 4 bytes "
              "of data, found [0, 8]");
  ExpectError(header(entry("a", "2", "0,4")), 4,
              "tensor \"a\": expected 8 bytes by dtype and shape, found 4");
  ExpectError(header(entry("a", "4611686018427387904", "0,4")), 4,
              "tensor \"a\": expected too many bytes by dtype and shape, "
              "found 4");
  ExpectError(header(entry("a", "1", "0,4")), 6,
              "expected 4 bytes of data, found 6");
  ExpectError(header(entry("a", "1", "0,4"), entry("a", "1", "4,8")), 8,
              "tensor \"a\" appears twice");
}

TEST(Safetensors, RefusesAHeaderLongerThanTheFile) {
  std::string bytes = SerializeSafetensors(SmallMap());
  bytes[7] = '\x7f';

  EXPECT_THAT(ParseSafetensors(bytes, "x"),
              StatusIs(kInvalid, HasSubstr("expected a header of at most")));
  EXPECT_THAT(ParseSafetensors("abc", "x"),
              StatusIs(kInvalid, "x: expected at least 8 bytes, found 3"));
}

TEST(Safetensors, RefusesEveryTruncation) {
  const std::string bytes = SerializeSafetensors(SmallMap(), {{"k", "v"}});

  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THAT(ParseSafetensors(bytes.substr(0, size), "cut"),
                StatusIs(kInvalid))
        << size;
  }
}

// Whatever the header, what comes out is consistent.
void ExpectConsistent(const absl::StatusOr<TensorMap>& read, size_t size) {
  if (!read.ok()) {
    EXPECT_THAT(read, StatusIs(kInvalid, HasSubstr("flipped: ")));
    return;
  }
  size_t bytes = 0;
  for (const auto& [name, tensor] : *read) bytes += tensor.data.size();
  EXPECT_LE(bytes, size);
}

TEST(Safetensors, SurvivesFlippedBits) {
  const std::string bytes = SerializeSafetensors(SmallMap(), {{"k", "v"}});

  for (uint64_t round = 0; round < 20'000; ++round) {
    std::string flipped = bytes;
    const RandomKey key = {.seed = 1, .episode = round};
    const uint64_t flips = 1 + UniformInt(key, 6, /*index=*/0);
    for (uint64_t i = 1; i <= flips; ++i) {
      const uint64_t bit = UniformInt(key, 8 * flipped.size(), i);
      flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    }
    ExpectConsistent(ParseSafetensors(flipped, "flipped"), flipped.size());
  }
}

TEST(Safetensors, ViewsTheSameTensorsWithoutCopyingAndTheMetadata) {
  const TensorMap tensors = SmallMap();
  const std::string bytes =
      SerializeSafetensors(tensors, {{"library", "ab"}, {"other", "c"}});

  const auto view = ViewSafetensors(bytes, "file");

  ASSERT_THAT(view, IsOk());
  EXPECT_EQ(view->metadata.at("library"), "ab");
  EXPECT_EQ(view->metadata.at("other"), "c");
  ASSERT_EQ(view->tensors.size(), tensors.size());
  for (const auto& [name, tensor] : tensors) {
    const TensorView& found = view->tensors.at(name);
    EXPECT_EQ(found.dtype, tensor.dtype);
    EXPECT_EQ(found.shape, tensor.shape);
    EXPECT_EQ(found.data, tensor.data);
    EXPECT_GE(found.data.data(), bytes.data());
    EXPECT_LE(found.data.data() + found.data.size(),
              bytes.data() + bytes.size());
  }
}

TEST(Safetensors, SurvivesDeepNesting) {
  for (const char* opening : {"[", "{\"a\":", "{\"a\":{\"shape\":["}) {
    std::string header;
    while (header.size() < 1'000'000) header += opening;
    EXPECT_THAT(ParseSafetensors(File(header, 0), "deep"), StatusIs(kInvalid));
  }
}

TEST(Safetensors, FindsTheFirstNumberThatIsNotFinite) {
  TensorMap tensors = SmallMap();
  EXPECT_THAT(CheckFinite(tensors, "file"), IsOk());

  tensors["b/weight"].mutable_float32()[4] =
      std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(
      CheckFinite(tensors, "file"),
      StatusIs(kInvalid, "file: tensor \"b/weight\": element 4 is not finite"));

  tensors["a"] = HostTensor::Float64({1}, {INFINITY});
  EXPECT_THAT(
      CheckFinite(tensors, "file"),
      StatusIs(kInvalid, "file: tensor \"a\": element 0 is not finite"));
}

}  // namespace
}  // namespace sinew
