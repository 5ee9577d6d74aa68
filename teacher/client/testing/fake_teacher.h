#ifndef SINEW_TEACHER_CLIENT_TESTING_FAKE_TEACHER_H_
#define SINEW_TEACHER_CLIENT_TESTING_FAKE_TEACHER_H_

#include <atomic>
#include <functional>
#include <vector>

#include "common/mutex.h"
#include "proto/sinew/v1/teacher.grpc.pb.h"

namespace sinew::teacher::testing {

// A teacher service that answers by a formula and misbehaves as it is told to:
//
//   target_j = base_j + (j + 1) * observation_0       spread_j = (j + 1) / 8
//
// Thread-safety: any thread. Ownership: copies. Blocking: as the fault does, or
// while it hangs. Errors: the fault's.
class FakeTeacher final : public v1::Teacher::Service {
 public:
  // Called for every Annotate, counted from 0, after the answer is there:
  // changes it, or returns an error, or waits for its own cancellation.
  using Fault = std::function<grpc::Status(
      int call, grpc::ServerContext& context, v1::AnnotateResponse& response)>;

  explicit FakeTeacher(Fault fault = {});

  // 3 observations, 2 actions, 8 rows a call, bundle "abc".
  static v1::DescribeTeacherResponse DefaultDescription();
  void SetDescription(const v1::DescribeTeacherResponse& description)
      SINEW_EXCLUDES(mu_);

  // From now on it takes calls and answers none, but by their cancellation; or
  // answers again, those too that it has taken.
  void SetHanging(bool hanging) { hanging_ = hanging; }

  int calls() const SINEW_EXCLUDES(mu_);
  // Of them those for more than a row, which no introduction asks for.
  int batches() const SINEW_EXCLUDES(mu_);
  // Rows of the largest call.
  int most_rows() const SINEW_EXCLUDES(mu_);

  grpc::Status Describe(grpc::ServerContext* context,
                        const v1::DescribeTeacherRequest* request,
                        v1::DescribeTeacherResponse* response) override
      SINEW_EXCLUDES(mu_);
  grpc::Status Annotate(grpc::ServerContext* context,
                        const v1::AnnotateRequest* request,
                        v1::AnnotateResponse* response) override
      SINEW_EXCLUDES(mu_);

 private:
  // Waits while it hangs; whether it may answer.
  bool MayAnswer(const grpc::ServerContext& context) const;

  const Fault fault_;
  std::atomic<bool> hanging_ = false;
  mutable Mutex mu_;
  v1::DescribeTeacherResponse description_ SINEW_GUARDED_BY(mu_);
  int calls_ SINEW_GUARDED_BY(mu_) = 0;
  int batches_ SINEW_GUARDED_BY(mu_) = 0;
  int most_rows_ SINEW_GUARDED_BY(mu_) = 0;
};

// Waits until the call is cancelled by its client or its server.
void AwaitCancellation(const grpc::ServerContext& context);

}  // namespace sinew::teacher::testing

#endif  // SINEW_TEACHER_CLIENT_TESTING_FAKE_TEACHER_H_
