#ifndef SINEW_TEACHER_CLIENT_REPLICA_H_
#define SINEW_TEACHER_CLIENT_REPLICA_H_

#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/rpc/credentials.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "proto/sinew/v1/teacher.grpc.pb.h"

namespace sinew::teacher {

// One teacher behind gRPC: its two calls, each with a deadline.
//
// Thread-safety: any thread. Ownership: owns its channel. Blocking: calls, at
// most `timeout`; they end at once when `stop` is requested. Errors: begin with
// the peer's name; a peer that ends a call is UNAVAILABLE, only `stop` gives
// CANCELLED.
class Replica {
 public:
  // As rpc::MakeChannel; does not connect yet.
  static absl::StatusOr<std::unique_ptr<Replica>> Create(
      const std::string& address, const rpc::Security& security);

  // "teacher HOST:PORT".
  const std::string& peer() const { return peer_; }

  absl::StatusOr<v1::DescribeTeacherResponse> Describe(
      const v1::DescribeTeacherRequest& request, absl::Duration timeout,
      const std::stop_token& stop) const;
  absl::StatusOr<v1::AnnotateResponse> Annotate(
      const v1::AnnotateRequest& request, absl::Duration timeout,
      const std::stop_token& stop) const;

 private:
  Replica(std::string peer, std::shared_ptr<grpc::Channel> channel);

  const std::string peer_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::Teacher::Stub> stub_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_REPLICA_H_
