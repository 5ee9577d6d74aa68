#include "tools/training/bundle_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::EqualsProto;

TEST(BundleMetrics, SayWhatOfTheEvaluationIsOfWhichClips) {
  EvaluationSummary summary;
  summary.training.clips = 7;
  summary.training.starts = 70;
  summary.training.succeeded_starts = 60;
  summary.training.success_rate = 0.5;
  summary.training.means.e_g_mpjpe_mm = 40;
  summary.training.means.e_mpjpe_mm = 20;
  summary.training.means.e_acc = 5;
  summary.training.means.e_vel = 6;
  summary.left_out.clips = 2;
  summary.left_out.starts = 20;
  summary.left_out.succeeded_starts = 3;
  summary.left_out.success_rate = 0.25;
  summary.left_out.means.e_g_mpjpe_mm = 90;
  summary.left_out.means.e_mpjpe_mm = 45;
  summary.left_out.means.e_acc = 9;
  summary.left_out.means.e_vel = 14;

  EXPECT_THAT(MakeBundleMetrics(summary, 12), EqualsProto(R"pb(
                clips: 7
                starts: 70
                succeeded_starts: 60
                success_rate: 0.5
                e_g_mpjpe_mm: 40
                e_mpjpe_mm: 20
                e_acc: 5
                e_vel: 6
                iteration: 12
                left_out_clips: 2
                left_out_starts: 20
                left_out_succeeded_starts: 3
                left_out_success_rate: 0.25
                left_out_e_g_mpjpe_mm: 90
                left_out_e_mpjpe_mm: 45
                left_out_e_acc: 9
                left_out_e_vel: 14
              )pb"));
}

}  // namespace
}  // namespace sinew::tools
