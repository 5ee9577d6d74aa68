#ifndef SINEW_TEACHER_SERVICE_TEACHER_SERVICE_H_
#define SINEW_TEACHER_SERVICE_TEACHER_SERVICE_H_

#include "absl/status/status.h"
#include "common/clock.h"
#include "proto/sinew/v1/teacher.grpc.pb.h"
#include "teacher/client/annotator.h"
#include "teacher/service/batcher.h"
#include "teacher/service/teacher_metrics.h"

namespace sinew::teacher {

// An annotator behind gRPC (teacher.proto): judges calls, on gRPC's threads,
// and hands their rows to a batcher.
//
// Thread-safety: gRPC calls it from many threads. Ownership: borrows
// everything; close the batcher before the server shuts down. Blocking: as
// Batcher::Annotate; calls without a deadline wait a minute at most. Errors: as
// teacher.proto says; DATA_LOSS where the annotator's own answer is wrong.
class TeacherService final : public v1::Teacher::Service {
 public:
  // Calls may have `max_batch_rows` rows, or as many as a message carries.
  TeacherService(const Annotator& annotator, Batcher& batcher,
                 int64_t max_batch_rows, Clock& clock, TeacherMetrics& metrics);

  grpc::Status Describe(grpc::ServerContext* context,
                        const v1::DescribeTeacherRequest* request,
                        v1::DescribeTeacherResponse* response) override;
  grpc::Status Annotate(grpc::ServerContext* context,
                        const v1::AnnotateRequest* request,
                        v1::AnnotateResponse* response) override;

 private:
  absl::Status Check(const v1::AnnotateRequest& request) const;
  absl::Status Answer(grpc::ServerContext& context,
                      const v1::AnnotateRequest& request,
                      v1::AnnotateResponse& response);

  const v1::DescribeTeacherResponse description_;
  const std::string spread_;  // as in the response
  Batcher& batcher_;
  Clock& clock_;
  TeacherMetrics& metrics_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_SERVICE_TEACHER_SERVICE_H_
