#include "sim/import/quality_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::import {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A walk as good as recordings get.
v1::ClipQuality GoodQuality() {
  v1::ClipQuality quality;
  quality.set_residual_force_bodyweights(0.05);
  quality.set_peak_torque_ratio(0.9);
  quality.set_penetration_max_m(0.004);
  quality.set_floating_mean_m(0.003);
  quality.set_peak_joint_speed(9);
  quality.set_foot_skate_m_per_s(0.015);
  return quality;
}

TEST(QualityGate, LetsAGoodClipPass) {
  const Verdict verdict = JudgeQuality(GoodQuality());

  EXPECT_EQ(verdict.status, ClipStatus::kOk);
  EXPECT_EQ(verdict.reason, "");
  EXPECT_THAT(verdict.findings, IsEmpty());
}

TEST(QualityGate, WarnsNamingFigureValueAndLimit) {
  v1::ClipQuality quality = GoodQuality();
  quality.set_penetration_max_m(0.06);
  quality.set_residual_force_bodyweights(0.5);

  const Verdict verdict = JudgeQuality(quality);

  EXPECT_EQ(verdict.status, ClipStatus::kWarned);
  EXPECT_THAT(verdict.findings,
              ElementsAre("unexplained root force 0.5 body weights, limit 0.35",
                          "largest depth below the floor 6 cm, limit 4"));
  EXPECT_EQ(verdict.reason, verdict.findings[0]);
}

TEST(QualityGate, RejectsWhatNoBodyDoes) {
  const auto reject = [](auto set, const char* figure) {
    v1::ClipQuality quality = GoodQuality();
    set(&quality);
    const Verdict verdict = JudgeQuality(quality);
    EXPECT_EQ(verdict.status, ClipStatus::kRejected) << figure;
    EXPECT_THAT(verdict.reason, HasSubstr(figure));
  };
  reject([](auto* q) { q->set_residual_force_bodyweights(1.2); },
         "unexplained root force 1.2 body weights, limit 1");
  reject([](auto* q) { q->set_peak_joint_speed(75); },
         "peak joint speed 75 rad/s, limit 60");
  reject([](auto* q) { q->set_penetration_max_m(0.12); },
         "largest depth below the floor 12 cm, limit 10");
  reject([](auto* q) { q->set_airborne_share(0.95); },
         "share of frames in the air 95 %, limit 90");
}

TEST(QualityGate, NamesTheRejectingFigureBeforeGraverWarnings) {
  v1::ClipQuality quality = GoodQuality();
  quality.set_residual_force_bodyweights(0.5);  // warns
  quality.set_peak_joint_speed(75);             // rejects

  const Verdict verdict = JudgeQuality(quality);

  EXPECT_THAT(verdict.reason, HasSubstr("peak joint speed"));
  EXPECT_THAT(verdict.findings, SizeIs(2));
}

TEST(QualityGate, RejectsFiguresThatAreNoNumbers) {
  v1::ClipQuality quality = GoodQuality();
  // A figure without an upper limit, too.
  quality.set_peak_torque_ratio(std::nan(""));
  EXPECT_EQ(JudgeQuality(quality).status, ClipStatus::kRejected);
  quality.set_peak_torque_ratio(std::numeric_limits<double>::infinity());
  EXPECT_EQ(JudgeQuality(quality).status, ClipStatus::kRejected);
}

TEST(QualityLimits, WarnBeforeTheyReject) {
  for (const QualityLimit& limit : QualityLimits()) {
    EXPECT_LT(limit.warn, limit.reject) << limit.figure;
    EXPECT_GT(limit.warn, 0) << limit.figure;
  }
}

}  // namespace
}  // namespace sinew::import
