#ifndef SINEW_TEACHER_LOCAL_ANNOTATOR_H_
#define SINEW_TEACHER_LOCAL_ANNOTATOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/ports.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/block_pool.h"
#include "teacher/client/annotator.h"
#include "teacher/target_law.h"
#include "teacher/teacher_policy.h"

namespace sinew::teacher {

// A teacher in this process: the executor on threads, rows in blocks. Noise is
// zero, so the executed tap is the mean. Results depend neither on threads nor
// on what shares a batch (executor.h), to the bit.
//
// Thread-safety: any thread; callers take turns, each with all threads.
// Ownership: owns copies of everything; shares its threads with those that are
// created beside it, whichever lives longest. Blocking: Annotate computes.
// Errors: as Annotator; Create.
class LocalAnnotator final : public Annotator {
 public:
  // INVALID_ARGUMENT: threads < 1; a graph without such ports, widths that
  // differ from the manifest's, weights that are not finite, an action law as
  // TargetLaw says. NOT_FOUND: no graph "policy".
  static absl::StatusOr<std::unique_ptr<LocalAnnotator>> Create(
      const TeacherPolicy& policy, int threads);

  // Another one on the threads of `other`, whose callers then take turns with
  // its own: several teachers of a process need no more threads than one.
  static absl::StatusOr<std::unique_ptr<LocalAnnotator>> CreateBeside(
      const LocalAnnotator& other, const TeacherPolicy& policy);

  // Its max_rows is that of int32: there is no limit.
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override;

 private:
  // What one worker computes with.
  struct Workspace {
    std::unique_ptr<policy::Executor> executor;
    int observation;  // input
    int action;       // tap
  };

  LocalAnnotator(TargetLaw law, v1::DescribeTeacherResponse description,
                 std::vector<double> spread, std::vector<Workspace> workspaces,
                 std::shared_ptr<BlockPool> pool);

  static absl::StatusOr<std::unique_ptr<LocalAnnotator>> CreateOn(
      std::shared_ptr<BlockPool> pool, const TeacherPolicy& policy);

  // Rows [first, first + count).
  absl::Status RunRows(Workspace& workspace, const Rows& rows, int64_t first,
                       int64_t count, absl::Span<double> targets) const;

  const TargetLaw law_;
  const v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_;
  // One per worker of the pool.
  std::vector<Workspace> workspaces_;
  // Shared with those beside it. Its threads use the above while Annotate runs.
  const std::shared_ptr<BlockPool> pool_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_LOCAL_ANNOTATOR_H_
