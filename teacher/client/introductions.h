#ifndef SINEW_TEACHER_CLIENT_INTRODUCTIONS_H_
#define SINEW_TEACHER_CLIENT_INTRODUCTIONS_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/rpc/retry.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/replica.h"

namespace sinew::teacher {

// How replicas are got to know before any row goes to them.
//
// Thread-safety: functions. Ownership: borrow. Blocking: as their timeouts say;
// `stop` ends them at once. Errors: begin with the peer's name.

// What a replica says of itself and of a sample row.
struct Introduction {
  v1::DescribeTeacherResponse description;  // with provenance
  std::vector<double> targets, spread;      // [A] each
};

// Asks one replica. `timeout`: of the call that comes next. Errors: the
// calls'; those of CheckDescription and ReadAnswer.
absl::StatusOr<Introduction> Introduce(
    const Replica& replica, absl::FunctionRef<absl::Duration()> timeout,
    const std::stop_token& stop);

// FAILED_PRECONDITION naming both peers: other than CheckAlike asks, or another
// answer to the sample row.
absl::Status CheckSameTeacher(const Introduction& expected,
                              const std::string& expected_peer,
                              const Introduction& found,
                              const std::string& found_peer);

struct IntroductionOptions {
  std::stop_token stop = {};
  absl::Duration call_timeout;
  absl::Duration patience;      // for any answer
  absl::Duration wait_for_all;  // for those that do not answer while others do
  rpc::BackoffOptions backoff = {};
};

// Asks all at the same time, again and again while they are away: they may
// still be starting. By replica; none: it does not answer, though another does.
// Errors: CANCELLED (stop); of the first one that answers with an error that
// does not pass, that error; where none answers within `patience`, UNAVAILABLE
// or DEADLINE_EXCEEDED naming every replica with its last error.
absl::StatusOr<std::vector<std::optional<Introduction>>> IntroduceAll(
    absl::Span<const std::unique_ptr<Replica>> replicas,
    const IntroductionOptions& options, Clock& clock);

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_INTRODUCTIONS_H_
