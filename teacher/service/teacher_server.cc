#include "teacher/service/teacher_server.h"

#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/logging.h"
#include "common/status_macros.h"

namespace sinew::teacher {
namespace {

constexpr int64_t kMostBatchRows = 1 << 16;
// A thousand columns each are 1 GiB.
constexpr int64_t kMostQueueRows = 1 << 18;
// Each may hold a message of rpc::kMaxMessageBytes, 2 GiB together; further
// calls get RESOURCE_EXHAUSTED.
constexpr int kMostThreads = 128;
constexpr absl::Duration kLongestDelay = absl::Seconds(10);
constexpr absl::Duration kFarewell = absl::Seconds(5);

absl::Status CheckBatches(const Batcher::Options& batches) {
  if (batches.max_batch_rows < 1 || batches.max_batch_rows > kMostBatchRows) {
    return absl::InvalidArgumentError(
        absl::StrCat("rows of a batch: expected 1 to ", kMostBatchRows,
                     ", found ", batches.max_batch_rows));
  }
  if (batches.queue_rows < batches.max_batch_rows ||
      batches.queue_rows > kMostQueueRows) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rows of the queue: expected ", batches.max_batch_rows,
        ", a batch, to ", kMostQueueRows, ", found ", batches.queue_rows));
  }
  if (batches.batch_delay < absl::ZeroDuration() ||
      batches.batch_delay > kLongestDelay) {
    return absl::InvalidArgumentError(absl::StrCat(
        "delay of a batch: expected 0 to ", absl::FormatDuration(kLongestDelay),
        ", found ", absl::FormatDuration(batches.batch_delay)));
  }
  return absl::OkStatus();
}

}  // namespace

TeacherServer::TeacherServer(std::unique_ptr<LocalAnnotator> annotator,
                             const Options& options, Clock& clock)
    : registry_({.role = "teacher", .build = BuildIdentity()}),
      metrics_(registry_),
      annotator_(std::move(annotator)),
      batcher_(*annotator_, options.batches, clock, metrics_),
      service_(*annotator_, batcher_, options.batches.max_batch_rows, clock,
               metrics_) {}

absl::StatusOr<std::unique_ptr<TeacherServer>> TeacherServer::Create(
    const Options& options, const TeacherPolicy& policy, Clock& clock) {
  SINEW_RETURN_IF_ERROR(CheckBatches(options.batches));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<LocalAnnotator> annotator,
                         LocalAnnotator::Create(policy, options.threads));
  std::unique_ptr<TeacherServer> result(
      new TeacherServer(std::move(annotator), options, clock));
  if (!options.metrics_address.empty()) {
    SINEW_ASSIGN_OR_RETURN(result->metrics_server_,
                           metrics::MetricsServer::Start(
                               options.metrics_address, result->registry_));
  }
  SINEW_ASSIGN_OR_RETURN(result->server_,
                         rpc::Server::Start({.address = options.address,
                                             .security = options.security,
                                             .max_threads = kMostThreads},
                                            {&result->service_}));
  return result;
}

TeacherServer::~TeacherServer() { Shutdown(absl::Seconds(1)); }

std::string TeacherServer::metrics_address() const {
  return metrics_server_ == nullptr ? "" : metrics_server_->address();
}

void TeacherServer::Shutdown(absl::Duration timeout) {
  if (server_ != nullptr) server_->Drain();
  batcher_.Close();
  if (server_ != nullptr) server_->Shutdown(timeout);
}

absl::Status RunTeacher(const TeacherServer::Options& options,
                        const TeacherPolicy& policy, const StopToken& stop) {
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TeacherServer> server,
                         TeacherServer::Create(options, policy, clock));
  const v1::DescribeTeacherResponse& teacher = server->description();
  LogInfo("serving a teacher",
          {{"address", server->address()},
           {"bundle_sha256", teacher.bundle_sha256()},
           {"observation_width", teacher.observation_width()},
           {"action_width", teacher.action_width()},
           {"threads", options.threads},
           {"metrics", server->metrics_address()}});
  AwaitStop(stop);
  LogInfo("teacher ends");
  server->Shutdown(kFarewell);
  return absl::OkStatus();
}

}  // namespace sinew::teacher
