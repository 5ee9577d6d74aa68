#include "teacher/client/remote_annotator.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "teacher/client/testing/annotator_rig.h"
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

class RemoteAnnotatorTest : public testing::AnnotatorRig {};

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

// Answers no part before `first` has been asked for as many as `batches` says.
FakeTeacher::Fault After(const FakeTeacher& first,
                         const std::atomic<int>& batches) {
  return [&](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
    while (call > 0 && first.batches() < batches && !context.IsCancelled()) {
      std::this_thread::yield();
    }
    return grpc::Status::OK;
  };
}

TEST_F(RemoteAnnotatorTest, GivesAReplicaThatHangsNoRowsUntilItAnswersAgain) {
  options_.calls_in_flight = 1;
  options_.call_timeout = absl::Hours(1);
  options_.late_floor = absl::Milliseconds(1);
  std::atomic<int> batches = 1;
  const absl::Cleanup join = [&] { servers_.clear(); };
  FakeTeacher& a = Add();
  Add(After(a, batches));
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  a.SetHanging(true);

  for (int i = 0; i < 2; ++i) {
    ASSERT_THAT(Annotate(**annotator), IsOk());
    EXPECT_EQ(targets_, expected_);
    EXPECT_EQ(a.batches(), 1);
  }

  // The other one now waits until it has got rows.
  a.SetHanging(false);
  batches = 2;
  ASSERT_THAT(Annotate(**annotator), IsOk());
  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, AnotherReplicaTakesOverFromOneThatIsSlow) {
  options_.calls_in_flight = 1;
  options_.call_timeout = absl::Hours(1);
  options_.late_floor = absl::Milliseconds(1);
  // Answers once the other has been asked for all 7 parts, its own included.
  FakeTeacher* other = nullptr;
  const std::atomic<int> batches = 1;
  const absl::Cleanup join = [&] { servers_.clear(); };
  const FakeTeacher& a =
      Add([&](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
        while (call > 0 && other->batches() < 7 && !context.IsCancelled()) {
          std::this_thread::yield();
        }
        return grpc::Status::OK;
      });
  other = &Add(After(a, batches));

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

// Another build may answer with other bits, and needs no failing call to come
// to an address.
TEST_F(RemoteAnnotatorTest, NeverUsesAnswersOfAnotherBuildThatHasComeQuietly) {
  std::atomic<bool> other = false;
  FakeTeacher& a =
      Add([&](int, grpc::ServerContext&, v1::AnnotateResponse& response) {
        if (other) response.mutable_targets()->assign(16 * 8, '\1');
        return grpc::Status::OK;
      });
  // Leaves the first part to the other.
  Add([&](int call, grpc::ServerContext& context, v1::AnnotateResponse&) {
    while (call > 0 && a.calls() < 2 && !context.IsCancelled()) {
      std::this_thread::yield();
    }
    return grpc::Status::OK;
  });
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_build("another");
  a.SetDescription(description);
  other = true;

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, RefusesAnswersOfAnotherCpuClass) {
  FakeTeacher& a = Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_cpu_class("x86-64-v4");
  a.SetDescription(description);

  EXPECT_THAT(Annotate(**annotator),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(options_.addresses[0]),
                             HasSubstr("CPU class: expected x86-64-v3"),
                             HasSubstr("found x86-64-v4"))));
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

TEST_F(RemoteAnnotatorTest,
       NamesTheFirstNumberThatIsNotFiniteAndSendsItNowhere) {
  std::atomic<bool> seen = false;
  Add([&](int, grpc::ServerContext&, v1::AnnotateResponse& response) {
    std::vector<double> targets(response.targets().size() / sizeof(double));
    std::memcpy(targets.data(), response.targets().data(),
                response.targets().size());
    for (const double one : targets) {
      if (!std::isfinite(one)) seen = true;
    }
    return grpc::Status::OK;
  });
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  observations_[3 * 4 + 1] = std::numeric_limits<float>::infinity();
  // 8 rows a call: the first and the last of 7 calls have one.
  observations_[3 * 49] = std::numeric_limits<float>::quiet_NaN();
  bases_[2 * 49] = std::numeric_limits<double>::quiet_NaN();

  EXPECT_THAT(
      Annotate(**annotator),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("observations: expected finite numbers, found inf in "
                         "row 4, column 1")));
  EXPECT_FALSE(seen);
}

TEST_F(RemoteAnnotatorTest, RefusesSuchNumbersThoughAReplicaIsAway) {
  Add();
  AddAbsent();
  observations_[5] = std::numeric_limits<float>::infinity();

  EXPECT_THAT(Annotate(), StatusIs(absl::StatusCode::kInvalidArgument));
}

// Of one that was restarted with smaller batches.
TEST_F(RemoteAnnotatorTest, LeavesOutAReplicaThatTakesFewerRowsNow) {
  FakeTeacher& a =
      Add([](int call, grpc::ServerContext&, v1::AnnotateResponse& response) {
        return call == 0 || response.targets().size() <= 2 * 2 * sizeof(double)
                   ? grpc::Status::OK
                   : grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "rows");
      });
  Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_max_rows(2);
  a.SetDescription(description);

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(RemoteAnnotatorTest, AsksOneThatHasRefusedRowsAgainWhatItIs) {
  options_.calls_in_flight = 1;
  std::atomic<bool> fewer = false;
  FakeTeacher& a =
      Add([&](int, grpc::ServerContext&, v1::AnnotateResponse& response) {
        return fewer && response.targets().size() > 2 * 2 * sizeof(double)
                   ? grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "rows")
                   : grpc::Status::OK;
      });
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_max_rows(2);
  a.SetDescription(description);
  fewer = true;

  EXPECT_THAT(Annotate(**annotator),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Annotate(**annotator),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("max_rows: expected 8 or more")));
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
