#include "teacher/client/replica.h"

#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "common/rpc/channel.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"

namespace sinew::teacher {
namespace {

absl::Status Call(const std::string& peer, absl::Duration timeout,
                  const std::stop_token& stop,
                  absl::FunctionRef<grpc::Status(grpc::ClientContext*)> call) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, timeout);
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  const absl::Status status = rpc::FromGrpc(call(&context), peer);
  // gRPC also says CANCELLED of a peer that is shutting down.
  if (absl::IsCancelled(status) && !stop.stop_requested()) {
    return absl::UnavailableError(
        absl::StrCat(status.message(), " (the peer ended the call)"));
  }
  return status;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Replica>> Replica::Create(
    const std::string& address, const rpc::Security& security) {
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                         rpc::MakeChannel(address, security));
  return std::unique_ptr<Replica>(
      new Replica(absl::StrCat("teacher ", address), std::move(channel)));
}

Replica::Replica(std::string peer, std::shared_ptr<grpc::Channel> channel)
    : peer_(std::move(peer)),
      channel_(std::move(channel)),
      stub_(v1::Teacher::NewStub(channel_)) {}

absl::StatusOr<v1::DescribeTeacherResponse> Replica::Describe(
    const v1::DescribeTeacherRequest& request, absl::Duration timeout,
    const std::stop_token& stop) const {
  v1::DescribeTeacherResponse response;
  SINEW_RETURN_IF_ERROR(
      Call(peer_, timeout, stop, [&](grpc::ClientContext* context) {
        return stub_->Describe(context, request, &response);
      }));
  return response;
}

absl::StatusOr<v1::AnnotateResponse> Replica::Annotate(
    const v1::AnnotateRequest& request, absl::Duration timeout,
    const std::stop_token& stop) const {
  v1::AnnotateResponse response;
  SINEW_RETURN_IF_ERROR(
      Call(peer_, timeout, stop, [&](grpc::ClientContext* context) {
        return stub_->Annotate(context, request, &response);
      }));
  return response;
}

}  // namespace sinew::teacher
