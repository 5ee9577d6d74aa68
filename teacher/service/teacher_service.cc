#include "teacher/service/teacher_service.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/finite.h"
#include "common/rpc/channel.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

// Of calls that have no deadline.
constexpr absl::Duration kLongestWait = absl::Minutes(1);
// Room for digests and headers beside the rows of a message.
constexpr int64_t kHeaderBytes = 64 << 10;

// Until a call's deadline, which is in wall time.
absl::Duration TimeLeft(const grpc::ServerContext& context) {
  const auto deadline = context.deadline();
  if (deadline == std::chrono::system_clock::time_point::max()) {
    return kLongestWait;
  }
  return absl::FromChrono(deadline - std::chrono::system_clock::now());
}

v1::DescribeTeacherResponse Limited(v1::DescribeTeacherResponse description,
                                    int64_t max_batch_rows) {
  const int64_t row_bytes =
      description.observation_width() * static_cast<int64_t>(sizeof(float)) +
      description.action_width() * static_cast<int64_t>(sizeof(double));
  const int64_t fitting = (rpc::kMaxMessageBytes - kHeaderBytes) / row_bytes;
  description.set_max_rows(static_cast<int32_t>(
      std::max<int64_t>(1, std::min(max_batch_rows, fitting))));
  return description;
}

absl::Status CheckBytes(const char* field, int64_t rows, int64_t row_bytes,
                        const std::string& bytes) {
  const auto expected = static_cast<uint64_t>(rows * row_bytes);
  if (bytes.size() == expected) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected ", rows, " rows of ", row_bytes,
                   " bytes, found ", bytes.size(), " bytes"));
}

// Names the first number that is not finite; of bytes that have one.
template <typename T>
absl::Status NotFinite(const char* field, const std::string& bytes,
                       int64_t width) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return CheckFiniteRows(field, absl::Span<const T>(values), width);
}

}  // namespace

TeacherService::TeacherService(const Annotator& annotator, Batcher& batcher,
                               int64_t max_batch_rows, Clock& clock,
                               TeacherMetrics& metrics)
    : description_(Limited(annotator.description(), max_batch_rows)),
      spread_(reinterpret_cast<const char*>(annotator.spread().data()),
              annotator.spread().size() * sizeof(double)),
      batcher_(batcher),
      clock_(clock),
      metrics_(metrics) {}

grpc::Status TeacherService::Describe(grpc::ServerContext*,
                                      const v1::DescribeTeacherRequest* request,
                                      v1::DescribeTeacherResponse* response) {
  *response = description_;
  if (!request->with_provenance()) response->clear_provenance();
  return grpc::Status::OK;
}

grpc::Status TeacherService::Annotate(grpc::ServerContext* context,
                                      const v1::AnnotateRequest* request,
                                      v1::AnnotateResponse* response) {
  const double begin = clock_.SteadySeconds();
  const absl::Status status = Answer(*context, *request, *response);
  metrics_.Count(status, clock_.SteadySeconds() - begin);
  // Of the two, INTERNAL is also what gRPC says of broken connections.
  return rpc::ToGrpc(absl::IsInternal(status)
                         ? absl::DataLossError(status.message())
                         : status);
}

absl::Status TeacherService::Check(const v1::AnnotateRequest& request) const {
  if (request.bundle_sha256() != description_.bundle_sha256()) {
    return absl::FailedPreconditionError(
        absl::StrCat("bundle: expected ", request.bundle_sha256(),
                     ", this teacher serves ", description_.bundle_sha256()));
  }
  const int64_t rows = request.rows();
  if (rows < 1 || rows > description_.max_rows()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rows: expected 1 to ", description_.max_rows(), ", found ", rows));
  }
  const int64_t observation = description_.observation_width();
  const int64_t action = description_.action_width();
  SINEW_RETURN_IF_ERROR(CheckBytes("observations", rows,
                                   observation * sizeof(float),
                                   request.observations()));
  SINEW_RETURN_IF_ERROR(
      CheckBytes("bases", rows, action * sizeof(double), request.bases()));
  if (!AllFinite32(request.observations())) {
    return NotFinite<float>("observations", request.observations(),
                            observation);
  }
  if (!AllFinite64(request.bases())) {
    return NotFinite<double>("bases", request.bases(), action);
  }
  return absl::OkStatus();
}

absl::Status TeacherService::Answer(grpc::ServerContext& context,
                                    const v1::AnnotateRequest& request,
                                    v1::AnnotateResponse& response) {
  SINEW_RETURN_IF_ERROR(Check(request));
  const absl::Duration left = TimeLeft(context);
  const Batcher::Call call = {
      .rows = request.rows(),
      .observations = request.observations(),
      .bases = request.bases(),
      .deadline = clock_.After(left),
      .cancelled = [&context] { return context.IsCancelled(); }};
  SINEW_ASSIGN_OR_RETURN(std::string targets, batcher_.Annotate(call));
  response.set_targets(std::move(targets));
  response.set_spread(spread_);
  response.set_build(description_.build());
  response.set_cpu_class(description_.cpu_class());
  return absl::OkStatus();
}

}  // namespace sinew::teacher
