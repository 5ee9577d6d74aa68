#ifndef SINEW_LEARNER_CURRICULUM_TESTING_CURRICULUM_RIG_H_
#define SINEW_LEARNER_CURRICULUM_TESTING_CURRICULUM_RIG_H_

#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "learner/curriculum/curriculum.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// What tests of the curriculum share.

// Two clips at 10 Hz: "loop" of 25 frames, "once" of 11 (10 startable).
inline v1::MotionLibrary MakeLibrary() {
  v1::MotionLibrary library;
  library.set_frames_per_second(10);
  auto& loop = *library.add_clips();
  loop.set_name("loop");
  loop.set_num_frames(25);
  loop.set_loops(true);
  auto& once = *library.add_clips();
  once.set_name("once");
  once.set_num_frames(11);
  return library;
}

inline std::unique_ptr<Curriculum> MakeCurriculum(v1::Start::Rule rule,
                                                  double uniform_share = 0.1) {
  v1::Start start;
  start.set_rule(rule);
  start.set_bin_seconds(1);
  start.set_uniform_share(uniform_share);
  auto curriculum = Curriculum::Create(start, MakeLibrary());
  EXPECT_TRUE(curriculum.ok()) << curriculum.status();
  return *std::move(curriculum);
}

inline v1::EpisodeEnd MakeEpisode(int clip, int start, int steps, bool failed) {
  v1::EpisodeEnd episode;
  episode.set_clip(clip);
  episode.set_start_frame(start);
  episode.set_steps(steps);
  episode.set_reason(failed ? v1::EpisodeEnd::REASON_TERMINATED
                            : v1::EpisodeEnd::REASON_TIME_LIMIT);
  episode.set_mean_body_distance(0.2);
  return episode;
}

// A curriculum whose window before a failure is 0.5 s, that is 5 frames.
inline std::unique_ptr<Curriculum> MakeAdaptive(
    const v1::MotionLibrary& library,
    const std::vector<std::string>& clip_sha256 = {}) {
  v1::Start start;
  start.set_rule(v1::Start::RULE_ADAPTIVE_BINS);
  start.set_bin_seconds(1);
  start.mutable_adaptive()->set_pre_failure_seconds(0.5);
  start.mutable_adaptive()->set_half_life_passages(10);
  auto curriculum = Curriculum::Create(start, library, clip_sha256);
  EXPECT_TRUE(curriculum.ok()) << curriculum.status();
  return *std::move(curriculum);
}

inline v1::EvaluationResult MakeResult(int clip, int start, int steps,
                                       int failed_at) {
  v1::EvaluationResult result;
  result.set_clip(clip);
  result.set_start_frame(start);
  result.set_steps(steps);
  result.set_success(failed_at < 0);
  result.set_failed_at_frame(failed_at);
  result.set_frames(failed_at < 0 ? steps : failed_at);
  result.set_sum_g_mpjpe_mm(30.0 * result.frames());
  return result;
}

inline double TotalProbability(const v1::CurriculumTable& table) {
  double total = 0;
  for (const auto& bin : table.bins()) total += bin.probability();
  return total;
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_TESTING_CURRICULUM_RIG_H_
