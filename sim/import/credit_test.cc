#include "sim/import/credit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace sinew::import {
namespace {

const Credit kOtherwise{"somewhere", "unknown"};
const Credit kMocap{"a mocap database", "free"};
const Credit kDance{"a dancer", "CC BY 4.0"};

TEST(CreditTest, AFileLiesWithinItselfAndItsFolders) {
  EXPECT_TRUE(LiesWithin("/clips/cmu/walk.bvh", "/clips/cmu/walk.bvh"));
  EXPECT_TRUE(LiesWithin("/clips/cmu/walk.bvh", "/clips/cmu"));
  EXPECT_TRUE(LiesWithin("/clips/cmu/walk.bvh", "/clips/cmu/"));
  EXPECT_TRUE(LiesWithin("/clips/cmu/walk.bvh", "/"));
  EXPECT_TRUE(LiesWithin("/clips/./cmu/../cmu/walk.bvh", "/clips//cmu"));
  EXPECT_TRUE(LiesWithin("cmu/walk.bvh", "./cmu"));
  EXPECT_TRUE(LiesWithin("cmu/walk.bvh", "."));
}

TEST(CreditTest, AFileDoesNotLieWithinAFolderWhoseNameMerelyBeginsAlike) {
  EXPECT_FALSE(LiesWithin("/clips/cmu_bvh/walk.bvh", "/clips/cmu"));
  EXPECT_FALSE(LiesWithin("/clips/cmu", "/clips/cmu/walk.bvh"));
  EXPECT_FALSE(LiesWithin("/clips/cmu/../walk.bvh", "/clips/cmu"));
}

TEST(CreditTest, TheNearestFolderGivesTheCredit) {
  const std::vector<PathCredit> credits = {{"/clips/cmu/05", kDance},
                                           {"/clips", kMocap}};
  EXPECT_EQ(CreditOf("/clips/cmu/05/05_02.bvh", credits, kOtherwise), kDance);
  EXPECT_EQ(CreditOf("/clips/cmu/02/02_01.bvh", credits, kOtherwise), kMocap);
  EXPECT_EQ(CreditOf("/other/02_01.bvh", credits, kOtherwise), kOtherwise);
  EXPECT_EQ(CreditOf("/clips/walk.bvh", {}, kOtherwise), kOtherwise);
}

TEST(CreditTest, OfEqualPathsTheLastGivesTheCredit) {
  EXPECT_EQ(CreditOf("/clips/walk.bvh",
                     {{"/clips", kMocap}, {"/clips/", kDance}}, kOtherwise),
            kDance);
}

TEST(CreditTest, JoinsWhatDiffers) {
  EXPECT_EQ(Joined(kMocap, kMocap), kMocap);
  EXPECT_EQ(Joined(Credit(), Credit()), Credit());
  EXPECT_EQ(Joined(kMocap, kDance),
            (Credit{"a mocap database; a dancer", "free; CC BY 4.0"}));
}

TEST(CreditTest, WhatHalfOfAClipDoesNotSayIsUnknown) {
  EXPECT_EQ(Joined(kMocap, Credit()),
            (Credit{"a mocap database; unknown", "free; unknown"}));
  EXPECT_EQ(Joined(Credit(), kDance),
            (Credit{"unknown; a dancer", "unknown; CC BY 4.0"}));
}

TEST(CreditTest, NothingLiesWithinAnEmptyPath) {
  EXPECT_FALSE(LiesWithin("/clips/walk.bvh", ""));
  EXPECT_FALSE(LiesWithin("", "/clips"));
  EXPECT_EQ(NearestCredit("/clips/walk.bvh", {{"", kMocap}}), nullptr);
}

}  // namespace
}  // namespace sinew::import
