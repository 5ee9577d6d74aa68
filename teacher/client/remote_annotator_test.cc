#include "teacher/client/remote_annotator.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "teacher/client/testing/fake_teacher.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::AwaitCancellation;
using testing::FakeTeacher;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

// Of 3 observations and 2 actions.
constexpr int64_t kRows = 50;

// Fake teachers on sockets a, b, ... and an annotator over all of them.
class RemoteAnnotatorTest : public ::testing::Test {
 protected:
  RemoteAnnotatorTest() {
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

TEST_F(RemoteAnnotatorTest, PutsAnswersOfManyCallsInTheirPlaces) {
  FakeTeacher& a = Add();
  options_.max_rows = 7;

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_EQ(a.most_rows(), 7);
  EXPECT_EQ(a.calls(), 1 + 8);  // the sample row; 50 rows by 7
}

TEST_F(RemoteAnnotatorTest, AsksForNoMoreRowsThanEveryReplicaTakes) {
  FakeTeacher& a = Add();
  FakeTeacher& b = Add();
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_max_rows(3);
  b.SetDescription(description);

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_LE(a.most_rows(), 3);
  EXPECT_LE(b.most_rows(), 3);
}

TEST_F(RemoteAnnotatorTest, DescribesTheTeacherAndItsSpread) {
  Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());

  EXPECT_EQ((*annotator)->description().bundle_sha256(), "abc");
  EXPECT_THAT((*annotator)->spread(), ::testing::ElementsAre(0.125, 0.25));
}

TEST_F(RemoteAnnotatorTest, AnotherReplicaTakesOverFromOneThatDiesMidWay) {
  std::atomic<bool> reached = false;
  Add([&](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
    if (call < 2) return grpc::Status::OK;
    reached = true;
    reached.notify_all();
    AwaitCancellation(context);
    return grpc::Status::CANCELLED;
  });
  Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  // The other replica may have done all parts before it dies.
  std::jthread killer([&] {
    reached.wait(false);
    servers_[0]->Shutdown(absl::ZeroDuration());
  });

  EXPECT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
  reached = true;
  reached.notify_all();
}

TEST_F(RemoteAnnotatorTest, AsksAgainWhenAnAnswerIsLate) {
  Add([](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
    if (call == 1) AwaitCancellation(context);
    return grpc::Status::OK;
  });
  options_.call_timeout = absl::Milliseconds(300);

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, NeverUsesNumbersThatAreNotFinite) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse& response) {
    if (call == 0) return grpc::Status::OK;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::memcpy(response.mutable_targets()->data() + 8, &nan, 8);
    return grpc::Status::OK;
  });
  Add();

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, EndsWhenEveryAnswerIsWrong) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse& response) {
    if (call > 0) response.mutable_targets()->pop_back();
    return grpc::Status::OK;
  });

  EXPECT_THAT(Annotate(), StatusIs(absl::StatusCode::kInternal,
                                   AllOf(HasSubstr("3 wrong answers"),
                                         HasSubstr(options_.addresses[0]),
                                         HasSubstr("targets: expected"))));
}

TEST_F(RemoteAnnotatorTest, NeverUsesAnswersOfTheWrongSizeOrSpread) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse& response) {
    if (call == 1) response.mutable_targets()->append("more");
    if (call == 2) response.clear_spread();
    if (call == 3) response.mutable_spread()->assign(16, '\0');
    return grpc::Status::OK;
  });
  Add();

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, WaitsWhileTheQueueIsFull) {
  FakeTeacher& a =
      Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
        return call >= 1 && call <= 4
                   ? grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "full")
                   : grpc::Status::OK;
      });

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_EQ(a.calls(), 1 + 4 + 7);  // 50 rows by 8
}

TEST_F(RemoteAnnotatorTest, RefusesReplicasThatDiffer) {
  Add();
  FakeTeacher& b = Add();
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_bundle_sha256("xyz");
  b.SetDescription(description);
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(options_.addresses[0]),
                             HasSubstr(options_.addresses[1]),
                             HasSubstr("bundle: expected abc"),
                             HasSubstr("found xyz"))));

  description = FakeTeacher::DefaultDescription();
  description.set_build("other");
  b.SetDescription(description);
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("build: expected build")));

  description = FakeTeacher::DefaultDescription();
  description.set_cpu_class("x86-64-v4");
  b.SetDescription(description);
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("CPU class: expected x86-64-v3")));
}

TEST_F(RemoteAnnotatorTest, GoesOnWithoutAReplicaThatDoesNotAnswer) {
  AddAbsent();
  Add();

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, WaitsAtTheBeginningForReplicasThatAreStarting) {
  Add();
  options_.wait_for_all = absl::Seconds(30);
  FakeTeacher& b =
      Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
        return call < 3 ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "soon")
                        : grpc::Status::OK;
      });

  ASSERT_THAT(ConnectAnnotator(options_), IsOk());

  EXPECT_EQ(b.calls(), 4);
}

TEST_F(RemoteAnnotatorTest, UsesAReplicaThatComesLater) {
  const std::string late = AddAbsent();
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0 ? grpc::Status::OK
                     : grpc::Status(grpc::StatusCode::UNAVAILABLE, "tired");
  });
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  FakeTeacher& b = Start(late);

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_GE(b.calls(), 1 + 7);  // the sample row; 50 rows by 8
}

TEST_F(RemoteAnnotatorTest, LeavesOutAReplicaThatComesLaterAndDiffers) {
  const std::string late = AddAbsent();
  std::atomic<bool> tired = true;
  Add([&](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0 || !tired
               ? grpc::Status::OK
               : grpc::Status(grpc::StatusCode::UNAVAILABLE, "tired");
  });
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  FakeTeacher& b = Start(
      late, [&](int, grpc::ServerContext&, v1::AnnotateResponse& response) {
        const double other = 1e-9;
        std::memcpy(response.mutable_targets()->data(), &other, 8);
        tired = false;
        return grpc::Status::OK;
      });

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_EQ(b.most_rows(), 1);  // sample rows alone
}

TEST_F(RemoteAnnotatorTest, LeavesOutAReplicaThatComesBackWithOtherNumbers) {
  std::atomic<bool> tired = true;
  Add([&](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0 || !tired
               ? grpc::Status::OK
               : grpc::Status(grpc::StatusCode::UNAVAILABLE, "tired");
  });
  FakeTeacher& b =
      Add([&](int call, grpc::ServerContext&, v1::AnnotateResponse& response) {
        if (call == 0) return grpc::Status::OK;
        if (call == 1)
          return grpc::Status(grpc::StatusCode::UNAVAILABLE, "away");
        const double other = 1e-9;
        std::memcpy(response.mutable_targets()->data(), &other, 8);
        tired = false;
        return grpc::Status::OK;
      });
  options_.calls_in_flight = 1;

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_EQ(b.calls(), 3);
}

TEST_F(RemoteAnnotatorTest, RefusesAReplicaWhoseNumbersDiffer) {
  Add();
  Add([](int, grpc::ServerContext&, v1::AnnotateResponse& response) {
    const double other = 1e-9;
    std::memcpy(response.mutable_targets()->data(), &other, 8);
    return grpc::Status::OK;
  });

  EXPECT_THAT(
      ConnectAnnotator(options_),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("sample row")));
}

TEST_F(RemoteAnnotatorTest, LeavesOutAReplicaThatHasBecomeAnother) {
  FakeTeacher& a = Add();
  FakeTeacher& b = Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_build("newer");
  b.SetDescription(description);

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
  EXPECT_EQ(b.calls(), 1);  // the sample row
  a.SetDescription(description);
  EXPECT_THAT(Annotate(**annotator),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("build: expected build"),
                             HasSubstr("found newer"))));
}

TEST_F(RemoteAnnotatorTest, GivesTheTeachersJudgementOfTheRowsOn) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0
               ? grpc::Status::OK
               : grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no rows");
  });

  EXPECT_THAT(Annotate(), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("no rows")));
}

TEST_F(RemoteAnnotatorTest, AsksAnotherReplicaForRowsThatOneRefuses) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0
               ? grpc::Status::OK
               : grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no rows");
  });
  Add();

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, NamesPeersThatNeverAnswer) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0 ? grpc::Status::OK
                     : grpc::Status(grpc::StatusCode::UNAVAILABLE, "tired");
  });
  options_.patience = absl::Milliseconds(200);

  EXPECT_THAT(Annotate(),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("no teacher answered within 200ms"),
                             HasSubstr(options_.addresses[0]))));

  options_.addresses = {folder_.Address("nobody"), folder_.Address("none")};
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("no answer within 200ms"),
                             HasSubstr(options_.addresses[0]),
                             HasSubstr(options_.addresses[1]))));
}

TEST_F(RemoteAnnotatorTest, ConnectsWithinItsPatienceHoweverLongACallMayBe) {
  absl::Duration left;
  Add([&](int, grpc::ServerContext& context, v1::AnnotateResponse&) {
    left =
        absl::FromChrono(context.deadline() - std::chrono::system_clock::now());
    AwaitCancellation(context);
    return grpc::Status::CANCELLED;
  });
  options_.call_timeout = absl::Minutes(10);
  options_.patience = absl::Milliseconds(300);

  const auto annotator = ConnectAnnotator(options_);
  servers_.clear();  // joins the handler

  EXPECT_THAT(annotator.status(),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       AllOf(HasSubstr(options_.addresses[0]),
                             HasSubstr("no answer within 300ms"))));
  EXPECT_LE(left, absl::Seconds(5));
}

TEST_F(RemoteAnnotatorTest, EndsWhenStopped) {
  Add([this](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
    if (call == 0) return grpc::Status::OK;
    stop_.request_stop();
    AwaitCancellation(context);
    return grpc::Status::CANCELLED;
  });
  options_.stop = stop_.get_token();

  EXPECT_THAT(Annotate(), StatusIs(absl::StatusCode::kCancelled));
}

TEST_F(RemoteAnnotatorTest, RefusesOptionsThatMakeNoSense) {
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("teachers: expected an address")));
  options_.addresses = {"nonsense"};
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kInvalidArgument));
  options_.addresses = {folder_.Address("a")};
  options_.max_rows = 0;
  EXPECT_THAT(ConnectAnnotator(options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("max_rows: expected >= 1, found 0")));
}

}  // namespace
}  // namespace sinew::teacher
