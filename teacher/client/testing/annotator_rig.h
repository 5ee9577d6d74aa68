#ifndef SINEW_TEACHER_CLIENT_TESTING_ANNOTATOR_RIG_H_
#define SINEW_TEACHER_CLIENT_TESTING_ANNOTATOR_RIG_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/socket_folder.h"
#include "gtest/gtest.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/client/testing/fake_teacher.h"

namespace sinew::teacher::testing {

// Of 3 observations and 2 actions.
inline constexpr int64_t kRows = 50;

// Fake teachers on sockets a, b, ... and an annotator over all of them.
class AnnotatorRig : public ::testing::Test {
 protected:
  AnnotatorRig() {
    for (int64_t i = 0; i < 3 * kRows; ++i) {
      observations_.push_back(static_cast<float>(i) / 7);
    }
    for (int64_t i = 0; i < 2 * kRows; ++i) {
      bases_.push_back(static_cast<double>(i) / 11);
      const double lead = observations_[i / 2 * 3];
      expected_.push_back(bases_[i] + static_cast<double>(i % 2 + 1) * lead);
    }
    options_.patience = absl::Seconds(30);
    options_.backoff = {.initial = absl::Milliseconds(1),
                        .longest = absl::Milliseconds(20)};
  }

  FakeTeacher& Add(FakeTeacher::Fault fault = {}) {
    const std::string address = folder_.Address(
        std::string(1, static_cast<char>('a' + teachers_.size())));
    options_.addresses.push_back(address);
    return Start(address, std::move(fault));
  }
  FakeTeacher& Start(const std::string& address,
                     FakeTeacher::Fault fault = {}) {
    teachers_.push_back(std::make_unique<FakeTeacher>(std::move(fault)));
    servers_.push_back(
        rpc::Server::Start({.address = address}, {teachers_.back().get()})
            .value());
    return *teachers_.back();
  }
  // The address of a replica that is not there.
  std::string AddAbsent() {
    options_.addresses.push_back(folder_.Address("absent"));
    options_.wait_for_all = absl::Milliseconds(100);
    return options_.addresses.back();
  }

  absl::Status Annotate() {
    auto annotator = ConnectAnnotator(options_);
    if (!annotator.ok()) return annotator.status();
    return Annotate(**annotator);
  }
  absl::Status Annotate(Annotator& annotator) {
    targets_.assign(2 * kRows, -1);
    return annotator.Annotate({.observations = observations_, .bases = bases_},
                              absl::MakeSpan(targets_));
  }

  std::stop_source stop_;
  const rpc::SocketFolder folder_;
  RemoteAnnotatorOptions options_;
  std::vector<float> observations_;
  std::vector<double> bases_, expected_, targets_;
  std::vector<std::unique_ptr<FakeTeacher>> teachers_;
  std::vector<std::unique_ptr<rpc::Server>> servers_;
};

}  // namespace sinew::teacher::testing

#endif  // SINEW_TEACHER_CLIENT_TESTING_ANNOTATOR_RIG_H_
