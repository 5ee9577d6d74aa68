#ifndef SINEW_LEARNER_CURRICULUM_CURRICULUM_H_
#define SINEW_LEARNER_CURRICULUM_CURRICULUM_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "learner/curriculum/start_rule.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// Where episodes start: a table of clip x time bin with visits, failures,
// running error and last visit, and of clips with what evaluations found of
// them; updated by the learner once per iteration and sent with every snapshot,
// so that all actors draw from one distribution.
//
//   Record, Record, ...    episodes of an iteration
//   RecordEvaluation       at the iteration where one takes effect
//   Reweigh                once, before the next snapshot is made
//
// Recent passages and failures (v1::CurriculumTable.Bin) are kept under every
// rule, of episodes alone: an evaluation fails by a laxer measure. A run
// through a clip passes its bins one after the other, a loop's again in each
// round. One that fails, or diverges, counts in the bin where it does, and in
// those before it by the share of the frames passed there that lie at most
// pre_failure_seconds before the failure: the cause lies there, and never
// before the start, which is a frame of the clip itself. With P passages in an
// iteration and B bins that starts are drawn from, Reweigh multiplies both
// counts of these by 2^(-P / (B * half_life_passages)), so that what counts as
// recent scales with the library.
//
// Where start.only_clips names some clips, starts are drawn from these alone;
// the others keep bins and statistics, their probability is 0 unless
// start.other_clips_share leaves them some, and evaluations count for all.
//
// Thread-safety: one caller. Ownership: owns the table and its rule. Blocking:
// never; Record does not allocate. Errors: Create names the field or the clip;
// Restore refuses a table of other bins or clips.
class Curriculum {
 public:
  // `frames_per_second` of the library; bins of start.bin_seconds each, the
  // last bin of a clip may be shorter. The last frame of a clip that does not
  // loop is no start; clips that are left out have no bins. `clip_sha256`: by
  // clip, or empty: then no clip is ever recognised in another library.
  // start.only_clips must be clips of the library that are not left out.
  static absl::StatusOr<std::unique_ptr<Curriculum>> Create(
      const v1::Start& start, const v1::MotionLibrary& library,
      absl::Span<const std::string> clip_sha256 = {});

  // Counts a finished episode of `iteration`: a visit for the bin where it
  // began, a failure for the bin where it failed (not where it diverged, which
  // only what is recent counts as failed), and as recent. Episodes that do not
  // begin on the reference do not count.
  void Record(const v1::EpisodeEnd& episode, int64_t iteration);
  // Counts an evaluation of the snapshot of `iteration`, for clips alone.
  // Results in the order of their orders; those of fallen states do not count.
  void RecordEvaluation(absl::Span<const v1::EvaluationResult> results,
                        int64_t iteration);
  // Forgets some of what was recent and recomputes probabilities.
  void Reweigh();

  const v1::CurriculumTable& table() const { return table_; }
  const StartRule& rule() const { return *rule_; }
  // Whether starts are drawn from a clip, as world::IsDrawn says.
  bool Draws(int clip) const { return clips_[clip].drawn; }

  // From a training state of the same library, bit for bit.
  // FAILED_PRECONDITION if bins or clips differ.
  absl::Status Restore(const v1::CurriculumTable& table);
  // Takes over what `table`, of another library, knows of clips that are
  // unchanged, by name and digest, and reweighs. Returns their number.
  int Adopt(const v1::CurriculumTable& table);

 private:
  Curriculum() = default;
  // Bins of a clip; none if it is left out.
  struct ClipBins {
    int first = 0, count = 0;
    int64_t frames = 0;  // that can be started at
    bool loops = false;
    bool drawn = false;  // starts are drawn from them
  };
  absl::Status AddClip(const v1::ClipInfo& info, const std::string& sha256);
  void MarkDrawn();
  // Bin of a frame of a clip that has bins; frames past the end wrap (looping
  // clips) or count for the last bin.
  v1::CurriculumTable::Bin& BinAt(const ClipBins& clip, int64_t frame);
  // Last frame, counted on over the end, that is in the bin of `frame` until
  // `end` at most.
  int64_t LastOfPassage(const ClipBins& clip,
                        const v1::CurriculumTable::Bin& bin, int64_t frame,
                        int64_t end) const;
  void RunThrough(const ClipBins& clip, int64_t start, int64_t steps,
                  bool failed);
  void Forget();
  // Statistics of a clip's bins, if those of `table` from `first` on are the
  // same.
  void AdoptBins(const ClipBins& clip, const v1::CurriculumTable& table,
                 int first);

  v1::CurriculumTable table_;
  std::vector<ClipBins> clips_;
  int drawn_bins_ = 0;
  int64_t pre_failure_frames_ = 0;
  double half_life_passages_ = 1;
  int64_t passages_ = 0;  // since the last Reweigh
  std::unique_ptr<StartRule> rule_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_CURRICULUM_H_
