#ifndef SINEW_LEARNER_CURRICULUM_CURRICULUM_H_
#define SINEW_LEARNER_CURRICULUM_CURRICULUM_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// Turns the statistics of bins into start probabilities.
//
// Thread-safety: stateless. Errors: none; the result sums to 1.
class StartRule {
 public:
  virtual ~StartRule() = default;
  // Sets `probability` of every bin from its statistics; at least one bin.
  virtual void Weigh(v1::CurriculumTable& table) const = 0;
};

// Every frame of every clip alike: probability proportional to bin frames.
std::unique_ptr<StartRule> MakeUniformRule();

// Proportional to frames times the smoothed failure rate
// (failures + 1) / (visits + 2), mixed with `uniform_share` of the uniform
// rule, which guarantees every bin its floor.
std::unique_ptr<StartRule> MakeFailureRateRule(double uniform_share);

// Where episodes start: a table of clip x time bin with visits, failures,
// running error and last visit, updated by the learner once per iteration and
// sent with every snapshot, so that all actors draw from one distribution.
//
// Thread-safety: one caller. Ownership: owns the table. Blocking: never.
// Errors: Create names the field; Restore refuses a table of other bins.
class Curriculum {
 public:
  // `frames_per_second` of the library; bins of start.bin_seconds each, the
  // last bin of a clip may be shorter. The last frame of a clip that does not
  // loop is no start.
  static absl::StatusOr<std::unique_ptr<Curriculum>> Create(
      const v1::Start& start, const v1::MotionLibrary& library);

  // Counts finished episodes of `iteration`: a visit for the bin where each
  // began, a failure for the bin where it failed.
  void Record(absl::Span<const v1::EpisodeEnd> episodes, int64_t iteration);
  // Recomputes probabilities; call once per iteration, after Record.
  void Reweigh();

  const v1::CurriculumTable& table() const { return table_; }
  // From a training state. FAILED_PRECONDITION if the bins differ.
  absl::Status Restore(const v1::CurriculumTable& table);

 private:
  Curriculum() = default;
  // Bin of a frame of a clip; frames past the end wrap (looping clips) or
  // count for the last bin.
  v1::CurriculumTable::Bin& BinAt(int clip, int64_t frame);

  v1::CurriculumTable table_;
  std::vector<int> first_bin_;   // by clip
  std::vector<int64_t> frames_;  // startable frames by clip
  std::vector<bool> loops_;
  std::unique_ptr<StartRule> rule_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_CURRICULUM_H_
