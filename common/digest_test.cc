#include "common/digest.h"

#include <string>

#include "gtest/gtest.h"
#include "proto/sinew/v1/bundle.pb.h"

namespace sinew {
namespace {

// Values of FIPS 180-4's examples.
constexpr char kEmpty[] =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr char kAbc[] =
    "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

TEST(Sha256Hex, GivesThePublishedValues) {
  EXPECT_EQ(Sha256Hex(""), kEmpty);
  EXPECT_EQ(Sha256Hex("abc"), kAbc);
}

TEST(Sha256, DoesNotDependOnHowBytesAreCut) {
  Sha256 digest;

  digest.Update("a");
  digest.Update("");
  digest.Update("bc");

  EXPECT_EQ(digest.FinishHex(), kAbc);
}

TEST(IsSha256Hex, AcceptsOnlySixtyFourLowerCaseDigits) {
  std::string upper = kAbc;
  upper[0] = 'B';

  EXPECT_TRUE(IsSha256Hex(kAbc));
  EXPECT_FALSE(IsSha256Hex(""));
  EXPECT_FALSE(IsSha256Hex(std::string(kAbc).substr(1)));
  EXPECT_FALSE(IsSha256Hex(std::string(kAbc) + "0"));
  EXPECT_FALSE(IsSha256Hex(upper));
  EXPECT_FALSE(IsSha256Hex(std::string(63, '0') + "g"));
}

TEST(SerializeDeterministically, IgnoresTheOrderOfInsertionIntoMaps) {
  v1::BundleManifest rising;
  v1::BundleManifest falling;
  for (int i = 0; i < 50; ++i) {
    (*rising.mutable_files())["f" + std::to_string(i)] = "x";
    (*falling.mutable_files())["f" + std::to_string(49 - i)] = "x";
  }

  EXPECT_EQ(SerializeDeterministically(rising),
            SerializeDeterministically(falling));
}

TEST(SerializeDeterministically, GivesBytesThatParseToTheSameMessage) {
  v1::BundleManifest manifest;
  manifest.set_character("humanoid");
  manifest.add_joints()->set_name("left_knee");

  v1::BundleManifest parsed;
  ASSERT_TRUE(parsed.ParseFromString(SerializeDeterministically(manifest)));

  EXPECT_EQ(parsed.character(), "humanoid");
  EXPECT_EQ(parsed.joints(0).name(), "left_knee");
}

}  // namespace
}  // namespace sinew
