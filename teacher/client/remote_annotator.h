#ifndef SINEW_TEACHER_CLIENT_REMOTE_ANNOTATOR_H_
#define SINEW_TEACHER_CLIENT_REMOTE_ANNOTATOR_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/rpc/credentials.h"
#include "common/rpc/retry.h"
#include "teacher/client/annotator.h"

namespace sinew::teacher {

struct RemoteAnnotatorOptions {
  // Replicas of one teacher, "HOST:PORT" or "unix:PATH"; at least one.
  std::vector<std::string> addresses = {};
  rpc::Security security = {};
  // Ends every wait with CANCELLED.
  std::stop_token stop = {};
  // Of one call, queueing included, > 0.
  absl::Duration call_timeout = absl::Seconds(30);
  // How long to go on without any success, > 0.
  absl::Duration patience = absl::Minutes(2);
  // How long to wait at the beginning for replicas that do not answer while
  // others do; <= 0: they are not waited for.
  absl::Duration wait_for_all = absl::Seconds(10);
  // Rows of a call at most, >= 1; replicas may ask for fewer.
  int64_t max_rows = 1024;
  // Calls to one replica at a time, >= 1: one travels while one is computed.
  int calls_in_flight = 2;
  rpc::BackoffOptions backoff = {};
  // When a part is taken over (ReplicaHealth::Options): >= 1; > 0.
  double late_factor = 4;
  absl::Duration late_floor = absl::Seconds(1);
};

// A teacher behind gRPC: one service or several replicas of it.
//
//   Annotate: rows -> parts of at most max_rows -> whichever replica is free
//             -> checked (build, CPU class, sizes, spread, finite numbers)
//             -> their place
//
// Every answer says who it is of, since a replica may have been restarted as
// another; one that was away or refused is asked again what it is before it
// gets more rows: by a thread of its own beside the batches, after a back-off
// (introductions.h), so that no batch waits for it. What is known of a replica
// stays from batch to batch (replica_health.h): one that hangs in one gets no
// rows in the next.
//
// A part that failed is asked again, elsewhere where that is possible. One that
// has been out for longer than late_factor parts of a replica that has nothing
// else to do, and late_floor, is asked of that one too; the first answer counts
// (part_queue.h has the exact rules). So the result does not depend on which
// replicas answered, nor on how often it took.
//
// All replicas that answer at the beginning must be alike: the same bundle,
// build and CPU class, and the same bytes in answer to a sample row. One that
// does not answer within `wait_for_all` is gone on without, as long as another
// does; when it comes, as when any comes back whose calls had failed, it is
// checked in the same way before it gets any row, and left out where it differs
// or takes fewer rows than those that were there. The log says who is missing,
// has come, or is left out.
//
// INVALID_ARGUMENT: an option out of range, an address; FAILED_PRECONDITION:
// replicas that differ, naming both, or one that makes no sense; UNAVAILABLE,
// DEADLINE_EXCEEDED: none answers within `patience` (all named); CANCELLED:
// stop. The annotator is as Annotator says; FAILED_PRECONDITION where all
// replicas have become others.
absl::StatusOr<std::unique_ptr<Annotator>> ConnectAnnotator(
    const RemoteAnnotatorOptions& options);

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_REMOTE_ANNOTATOR_H_
