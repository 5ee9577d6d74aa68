#include "teacher/service/teacher_server.h"

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/rpc/channel.h"
#include "common/rpc/status.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/teacher.grpc.pb.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/testing/toy_teacher.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MakeToyRows;
using testing::MakeToyStudent;
using testing::MakeToyTeacher;
using testing::ToyRows;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

class TeacherServerTest : public ::testing::Test {
 protected:
  std::unique_ptr<TeacherServer> Start(const std::string& name,
                                       const TeacherPolicy& policy,
                                       int threads = 1) {
    return TeacherServer::Create(
               {.address = folder_.Address(name),
                .threads = threads,
                .batches = {.max_batch_rows = 32, .queue_rows = 64}},
               policy, clock_)
        .value();
  }

  // A call by hand.
  static absl::Status Annotate(const std::string& address,
                               const v1::AnnotateRequest& request) {
    const auto stub = v1::Teacher::NewStub(*rpc::MakeChannel(address, {}));
    grpc::ClientContext context;
    rpc::SetTimeout(context, absl::Seconds(30));
    v1::AnnotateResponse response;
    return rpc::FromGrpc(stub->Annotate(&context, request, &response), "t");
  }

  static v1::AnnotateRequest MakeRequest(const ToyRows& rows) {
    v1::AnnotateRequest request;
    request.set_bundle_sha256(std::string(64, 'a'));
    request.set_rows(static_cast<int32_t>(rows.bases.size() / 3));
    request.set_observations(
        reinterpret_cast<const char*>(rows.observations.data()),
        rows.observations.size() * sizeof(float));
    request.set_bases(reinterpret_cast<const char*>(rows.bases.data()),
                      rows.bases.size() * sizeof(double));
    return request;
  }

  SystemClock clock_;
  const rpc::SocketFolder folder_;
};

TEST_F(TeacherServerTest, GivesTheBytesOfATeacherInProcess) {
  const ToyRows rows = MakeToyRows(300);
  for (const TeacherPolicy& policy : {MakeToyTeacher(), MakeToyStudent()}) {
    const auto local = LocalAnnotator::Create(policy, 2).value();
    const auto a = Start("a", policy);
    const auto b = Start("b", policy, /*threads=*/3);
    const auto remote = ConnectAnnotator(
        {.addresses = {a->address(), b->address()}, .max_rows = 19});
    ASSERT_THAT(remote, IsOk());
    std::vector<double> here(rows.bases.size()), there(rows.bases.size());

    ASSERT_THAT(local->Annotate(rows.rows(), absl::MakeSpan(here)), IsOk());
    ASSERT_THAT((*remote)->Annotate(rows.rows(), absl::MakeSpan(there)),
                IsOk());

    EXPECT_EQ(here, there);
    EXPECT_EQ(local->spread(), (*remote)->spread());
  }
}

TEST_F(TeacherServerTest, DescribesItsBundleAsATeacherInProcessDoes) {
  const TeacherPolicy policy = MakeToyTeacher();
  const auto local = LocalAnnotator::Create(policy, 1).value();
  const auto server = Start("a", policy);
  const auto remote = ConnectAnnotator({.addresses = {server->address()}});
  ASSERT_THAT(remote, IsOk());

  const v1::DescribeTeacherResponse& found = (*remote)->description();

  EXPECT_EQ(found.control_hz(), 30);
  EXPECT_THAT(found.provenance(),
              EqualsProto(local->description().provenance()));
  EXPECT_EQ(found.provenance().clips_size(), 1);
}

TEST_F(TeacherServerTest, SaysWhatItWasTrainedOnOnlyWhereAsked) {
  const auto server = Start("a", MakeToyTeacher());
  const auto stub =
      v1::Teacher::NewStub(*rpc::MakeChannel(server->address(), {}));
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(30));
  v1::DescribeTeacherResponse response;

  ASSERT_TRUE(stub->Describe(&context, {}, &response).ok());

  EXPECT_EQ(response.bundle_sha256(), std::string(64, 'a'));
  EXPECT_FALSE(response.has_provenance());
}

TEST_F(TeacherServerTest, ConnectsToNoReplicasOfDifferentTeachers) {
  TeacherPolicy other = MakeToyTeacher(/*seed=*/2);
  const auto a = Start("a", MakeToyTeacher());
  const auto b = Start("b", other);

  // By their numbers, since both claim the same digest.
  EXPECT_THAT(
      ConnectAnnotator({.addresses = {a->address(), b->address()}}),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr(b->address())));
}

TEST_F(TeacherServerTest, RefusesAnotherBundleNamingBoth) {
  const auto server = Start("a", MakeToyTeacher());
  v1::AnnotateRequest request = MakeRequest(MakeToyRows(1));
  request.set_bundle_sha256("other");

  EXPECT_THAT(Annotate(server->address(), request),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("expected other"),
                             HasSubstr(std::string(64, 'a')))));
}

TEST_F(TeacherServerTest, RefusesCallsThatDoNotFit) {
  const auto server = Start("a", MakeToyTeacher());
  const std::string& address = server->address();

  v1::AnnotateRequest request = MakeRequest(MakeToyRows(33));
  EXPECT_THAT(Annotate(address, request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("rows: expected 1 to 32, found 33")));
  request.set_rows(0);
  EXPECT_THAT(Annotate(address, request),
              StatusIs(absl::StatusCode::kInvalidArgument));

  request = MakeRequest(MakeToyRows(2));
  request.mutable_observations()->pop_back();
  EXPECT_THAT(Annotate(address, request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("observations: expected 2 rows of 84 bytes")));

  request = MakeRequest(MakeToyRows(2));
  request.clear_bases();
  EXPECT_THAT(Annotate(address, request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("bases: expected 2 rows of 24 bytes")));

  ToyRows rows = MakeToyRows(2);
  rows.bases[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Annotate(address, MakeRequest(rows)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("bases: expected finite numbers, found nan "
                                 "in row 1, column 1")));
  rows = MakeToyRows(2);
  rows.observations[3] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(Annotate(address, MakeRequest(rows)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("observations: expected finite numbers")));
}

TEST_F(TeacherServerTest, TellsWhoeverCallsThatItGoesAway) {
  const auto server = Start("a", MakeToyTeacher());
  const auto remote = ConnectAnnotator(
      {.addresses = {server->address()}, .patience = absl::Milliseconds(200)});
  ASSERT_THAT(remote, IsOk());
  const ToyRows rows = MakeToyRows(2);
  std::vector<double> targets(6);

  server->Shutdown(absl::Seconds(5));

  EXPECT_THAT(
      (*remote)->Annotate(rows.rows(), absl::MakeSpan(targets)),
      StatusIs(absl::StatusCode::kUnavailable, HasSubstr(server->address())));
}

TEST_F(TeacherServerTest, RefusesBoundsOutOfRange) {
  const auto create = [&](const Batcher::Options& batches) {
    return TeacherServer::Create(
               {.address = folder_.Address("a"), .batches = batches},
               MakeToyTeacher(), clock_)
        .status();
  };

  EXPECT_THAT(create({.max_batch_rows = 0}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("rows of a batch: expected 1 to 65536")));
  EXPECT_THAT(
      create({.max_batch_rows = 8, .queue_rows = 7}),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("rows of the queue: expected 8, a batch, to")));
  EXPECT_THAT(create({.batch_delay = absl::Minutes(1)}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("delay of a batch")));
}

TEST_F(TeacherServerTest, NamesAnAddressThatIsInUse) {
  const auto server = Start("a", MakeToyTeacher());

  EXPECT_THAT(
      TeacherServer::Create({.address = server->address()}, MakeToyTeacher(),
                            clock_),
      StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr(server->address())));
}

TEST(RunTeacher, EndsWhenAskedTo) {
  const rpc::SocketFolder folder;
  StopSource stop;
  stop.request_stop();

  EXPECT_THAT(RunTeacher({.address = folder.Address("a"),
                          .metrics_address = "127.0.0.1:0"},
                         MakeToyTeacher(), stop.get_token()),
              IsOk());
}

}  // namespace
}  // namespace sinew::teacher
