// How ConnectAnnotator gets to know its replicas, and those that come later.

#include "teacher/client/introductions.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <string>

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
using ::testing::AnyOf;
using testing::AwaitCancellation;
using testing::FakeTeacher;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

class IntroductionsTest : public testing::AnnotatorRig {};

TEST_F(IntroductionsTest, RefusesReplicasThatDiffer) {
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

TEST_F(IntroductionsTest, GoesOnWithoutAReplicaThatDoesNotAnswer) {
  AddAbsent();
  Add();

  ASSERT_THAT(Annotate(), IsOk());

  EXPECT_EQ(targets_, expected_);
}

TEST_F(IntroductionsTest, WaitsAtTheBeginningForReplicasThatAreStarting) {
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

TEST_F(IntroductionsTest, UsesAReplicaThatComesLater) {
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

TEST_F(IntroductionsTest, LeavesOutAReplicaThatComesLaterAndDiffers) {
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

TEST_F(IntroductionsTest, LeavesOutAReplicaThatComesBackWithOtherNumbers) {
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
  EXPECT_EQ(b.batches(), 1);
}

TEST_F(IntroductionsTest, RefusesAReplicaWhoseNumbersDiffer) {
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

TEST_F(IntroductionsTest, LeavesOutAReplicaThatHasBecomeAnother) {
  FakeTeacher& a = Add();
  FakeTeacher& b = Add();
  const auto annotator = ConnectAnnotator(options_);
  ASSERT_THAT(annotator, IsOk());
  v1::DescribeTeacherResponse description = FakeTeacher::DefaultDescription();
  description.set_build("newer");
  b.SetDescription(description);

  ASSERT_THAT(Annotate(**annotator), IsOk());

  EXPECT_EQ(targets_, expected_);
  // What was on its way when the first answer came.
  EXPECT_LE(b.batches(), options_.calls_in_flight);
  a.SetDescription(description);
  EXPECT_THAT(Annotate(**annotator),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("build: expected build"),
                             HasSubstr("found newer"))));
}

TEST_F(IntroductionsTest, NamesPeersThatNeverAnswer) {
  Add([](int call, grpc::ServerContext&, v1::AnnotateResponse&) {
    return call == 0 ? grpc::Status::OK
                     : grpc::Status(grpc::StatusCode::UNAVAILABLE, "tired");
  });
  options_.patience = absl::Milliseconds(200);

  EXPECT_THAT(Annotate(),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("no teacher answered within 200ms"),
                             HasSubstr(options_.addresses[0]))));

  // A machine that does much else may not even refuse in time.
  options_.addresses = {folder_.Address("nobody"), folder_.Address("none")};
  const auto names =
      AllOf(HasSubstr("no answer within 200ms"),
            HasSubstr(options_.addresses[0]), HasSubstr(options_.addresses[1]));
  EXPECT_THAT(ConnectAnnotator(options_),
              AnyOf(StatusIs(absl::StatusCode::kUnavailable, names),
                    StatusIs(absl::StatusCode::kDeadlineExceeded, names)));
}

TEST_F(IntroductionsTest, ConnectsWithinItsPatienceHoweverLongACallMayBe) {
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

}  // namespace
}  // namespace sinew::teacher
