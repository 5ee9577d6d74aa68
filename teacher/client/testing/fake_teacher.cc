#include "teacher/client/testing/fake_teacher.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "absl/time/time.h"
#include "common/rpc/retry.h"

namespace sinew::teacher::testing {
namespace {

template <typename T>
std::vector<T> Numbers(const std::string& bytes) {
  std::vector<T> numbers(bytes.size() / sizeof(T));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(T));
  return numbers;
}

std::string Bytes(const std::vector<double>& numbers) {
  return std::string(reinterpret_cast<const char*>(numbers.data()),
                     numbers.size() * sizeof(double));
}

}  // namespace

FakeTeacher::FakeTeacher(Fault fault)
    : fault_(std::move(fault)), description_(DefaultDescription()) {}

v1::DescribeTeacherResponse FakeTeacher::DefaultDescription() {
  v1::DescribeTeacherResponse description;
  description.set_bundle_sha256("abc");
  description.set_build("build");
  description.set_cpu_class("x86-64-v3");
  description.set_observation_width(3);
  description.set_action_width(2);
  description.set_max_rows(8);
  return description;
}

void FakeTeacher::SetDescription(
    const v1::DescribeTeacherResponse& description) {
  MutexLock lock(mu_);
  description_ = description;
}

int FakeTeacher::calls() const {
  MutexLock lock(mu_);
  return calls_;
}

int FakeTeacher::batches() const {
  MutexLock lock(mu_);
  return batches_;
}

int FakeTeacher::most_rows() const {
  MutexLock lock(mu_);
  return most_rows_;
}

bool FakeTeacher::MayAnswer(const grpc::ServerContext& context) const {
  while (hanging_ && !context.IsCancelled()) {
    rpc::WaitFor(absl::Milliseconds(5), {});
  }
  return !context.IsCancelled();
}

grpc::Status FakeTeacher::Describe(grpc::ServerContext* context,
                                   const v1::DescribeTeacherRequest*,
                                   v1::DescribeTeacherResponse* response) {
  if (!MayAnswer(*context)) return grpc::Status::CANCELLED;
  MutexLock lock(mu_);
  *response = description_;
  return grpc::Status::OK;
}

grpc::Status FakeTeacher::Annotate(grpc::ServerContext* context,
                                   const v1::AnnotateRequest* request,
                                   v1::AnnotateResponse* response) {
  int call = 0;
  int64_t observation = 0, action = 0;
  {
    MutexLock lock(mu_);
    call = calls_++;
    if (request->rows() > 1) ++batches_;
    most_rows_ = std::max(most_rows_, request->rows());
    if (request->bundle_sha256() != description_.bundle_sha256()) {
      return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                          "another bundle");
    }
    response->set_build(description_.build());
    response->set_cpu_class(description_.cpu_class());
    observation = description_.observation_width();
    action = description_.action_width();
  }
  if (!MayAnswer(*context)) return grpc::Status::CANCELLED;
  const auto observations = Numbers<float>(request->observations());
  auto targets = Numbers<double>(request->bases());
  for (size_t i = 0; i < targets.size(); ++i) {
    const auto row = static_cast<int64_t>(i) / action;
    const auto j = static_cast<int64_t>(i) % action;
    targets[i] += static_cast<double>(j + 1) * observations[row * observation];
  }
  std::vector<double> spread;
  for (int64_t j = 0; j < action; ++j) {
    spread.push_back(static_cast<double>(j + 1) / 8);
  }
  response->set_targets(Bytes(targets));
  response->set_spread(Bytes(spread));
  return fault_ ? fault_(call, *context, *response) : grpc::Status::OK;
}

void AwaitCancellation(const grpc::ServerContext& context) {
  while (!context.IsCancelled()) rpc::WaitFor(absl::Milliseconds(5), {});
}

}  // namespace sinew::teacher::testing
