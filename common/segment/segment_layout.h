#ifndef SINEW_COMMON_SEGMENT_SEGMENT_LAYOUT_H_
#define SINEW_COMMON_SEGMENT_SEGMENT_LAYOUT_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// The columns of a training segment: the one list that the actor fills, replay
// checks and the learner reads.
//
// T control steps, E environments, K truncated steps, O observation width, A
// action width (one per joint), Z width of a latent that PPO learns. Row t of
// environment e describes the step from state s_t to s_{t+1}:
//
//   observation             [T, E, O] float32  of s_t, not normalised
//   action                  [T, E, A] float32  as sampled, before any clipping
//   action_mean             [T, E, A] float32  mean of the sampled Gaussian
//   target                  [T, E, A] float64  joint-position target, rad
//   log_probability         [T, E]    float32  of action, natural logarithm
//   reward                  [T, E]    float32
//   reward_terms            [T, E, 4] float32  kernels before weighting, (0, 1]
//   body_distance           [T, E]    float32  mean over tracked bodies, m
//   terminated              [T, E]    uint8    1: failed at s_{t+1}
//   truncated               [T, E]    uint8    1: cut off at s_{t+1}, not
//                                              failed
//   valid                   [T, E]    uint8    0: the simulation diverged
//   clip, frame             [T, E]    int32    reference at s_t
//   base, teacher_base      [T, E, A] float64  rad; only where the recipe has
//                                              distillation, see below
//   latent_noise            [T, E, Z] float32  only where PPO learns a latent,
//                                              see below
//   boundary_observation    [E, O]    float32  of s_T
//   truncation_index        [K]       int32    t * E + e of truncated steps
//   truncation_observation  [K, O]    float32  of their s_{t+1}
//
// An episode ends at terminated or truncated (never both); the environment's
// next row is the first of a new one. The value of a step's successor is 0 if
// terminated; else that of truncation_observation if truncated; else that of
// the next row's observation, or of boundary_observation at t = T - 1.
// boundary_observation is taken before any reset, so it is s_T of the episode
// that row T - 1 belongs to; zeros if that step diverged.
//
// A diverged step has valid 0, terminated 1, reward 0: no loss and no statistic
// may use the row, and the step before it sees a failure.
//
// Distillation. base is what the student's action law (Recipe.task.action) adds
// to its scaled actions at s_t before it limits the sum to the joint's range
// (sim/world/action.h); teacher_base is the same of the teacher's law
// (Recipe.distillation.teacher_action). So a teacher's target is, in units of
// the student's action, (target - base) / scale. action, action_mean and target
// are those of whoever acted (episode_actor.h): in episodes of the teacher its
// own mean, twice, and the target that its law makes of it; in episodes of the
// prior its action, twice. In the student's own, action and target have the
// noise of Distillation.action_noise, action_mean and log_probability do not.
// Policies whose action has no distribution have log_probability 0.
//
// Learnt latents. latent_noise is the N(0, 1) noise that chose the latent among
// those that the policy's posterior thinks likely (tap "latent_noise" of its
// graph). action_mean and log_probability are those given this noise: whoever
// evaluates the policy again needs it.
namespace column {
inline constexpr absl::string_view kObservation = "observation";
inline constexpr absl::string_view kAction = "action";
inline constexpr absl::string_view kActionMean = "action_mean";
inline constexpr absl::string_view kTarget = "target";
inline constexpr absl::string_view kLogProbability = "log_probability";
inline constexpr absl::string_view kReward = "reward";
inline constexpr absl::string_view kRewardTerms = "reward_terms";
inline constexpr absl::string_view kBodyDistance = "body_distance";
inline constexpr absl::string_view kTerminated = "terminated";
inline constexpr absl::string_view kTruncated = "truncated";
inline constexpr absl::string_view kValid = "valid";
inline constexpr absl::string_view kClip = "clip";
inline constexpr absl::string_view kFrame = "frame";
inline constexpr absl::string_view kBase = "base";
inline constexpr absl::string_view kTeacherBase = "teacher_base";
inline constexpr absl::string_view kLatentNoise = "latent_noise";
inline constexpr absl::string_view kBoundaryObservation =
    "boundary_observation";
inline constexpr absl::string_view kTruncationIndex = "truncation_index";
inline constexpr absl::string_view kTruncationObservation =
    "truncation_observation";
}  // namespace column

// Number of reward terms: position, rotation, linear and angular velocity.
inline constexpr int kNumRewardTerms = 4;

// Pure functions; thread-safe; never block.

// The layout above for given widths, both >= 1; with base and teacher_base
// exactly where `distillation`, that is Recipe.has_distillation(), and with
// latent_noise where its width is not 0: RecordedLatentWidth
// (common/config/recipe.h).
v1::SegmentLayout MakeSegmentLayout(int64_t observation_width,
                                    int64_t action_width,
                                    bool distillation = false,
                                    int64_t latent_noise_width = 0);

// SHA-256 (hex) that orders and segments carry.
std::string LayoutSha256(const v1::SegmentLayout& layout);

// The column of that name, or null.
const v1::Tensor* FindColumn(const v1::Segment& segment,
                             absl::string_view name);
v1::Tensor* FindColumn(v1::Segment& segment, absl::string_view name);

// Bytes of one element; 0 for an unknown type.
int64_t ElementBytes(v1::DataType dtype);

// Columns are exactly those of the layout, in its order, with the types and
// shapes that `steps` and `environments` give; flags are 0 or 1 and never both
// terminated and truncated; truncation_index names exactly the truncated steps.
// Total: any message gives OK or INVALID_ARGUMENT naming column, expected and
// found.
absl::Status CheckColumns(const v1::Segment& segment,
                          const v1::SegmentLayout& layout, int64_t steps,
                          int64_t environments);

// Every floating-point column is finite. INVALID_ARGUMENT names column and
// element. Precondition: CheckColumns passed.
absl::Status CheckColumnsFinite(const v1::Segment& segment);

}  // namespace sinew

#endif  // SINEW_COMMON_SEGMENT_SEGMENT_LAYOUT_H_
