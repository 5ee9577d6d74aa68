#include "deploy/checkpoint/service/checkpoint_service.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/blobs/blob_reader.h"
#include "common/blobs/blobs_service.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/refused_channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/checkpoint_client.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
#include "deploy/checkpoint/client/testing/store_conformance.h"
#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Pointee;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

// A store behind a socket, and its client.
class OverGrpc : public StoreFixture {
 public:
  enum class First { kServer, kClient };

  explicit OverGrpc(const CheckpointService::Options& options = {},
                    const CheckpointClient::Options& client_options =
                        {.peer = "checkpoint test"},
                    First first = First::kServer)
      : service_(memory, options, clock_, metrics_),
        blobs_(service_.counted_blobs()) {
    const std::string address = folder_.Address("s");
    if (first == First::kClient) channel = rpc::RefusedChannel(address);
    server_ = *rpc::Server::Start({.address = address}, {&service_, &blobs_});
    if (channel == nullptr) channel = *rpc::MakeChannel(address, {});
    client_ = std::make_unique<CheckpointClient>(channel, client_options);
  }
  ArtifactStore& store() override { return *client_; }

  metrics::Registry registry{{.role = "checkpoint", .build = ""}};
  MemoryStore memory;
  std::shared_ptr<grpc::Channel> channel;

 private:
  const rpc::SocketFolder folder_;
  const SystemClock clock_;
  ServiceMetrics metrics_{registry};
  CheckpointService service_;
  BlobsService blobs_;
  std::unique_ptr<CheckpointClient> client_;
  // Last: its threads use all of the above.
  std::unique_ptr<rpc::Server> server_;
};

INSTANTIATE_TEST_SUITE_P(OverGrpc, StoreConformance,
                         ::testing::Values(StoreMaker([] {
                           return std::make_unique<OverGrpc>();
                         })));

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

v1::PutBlobRequest Header(const std::string& bytes) {
  v1::PutBlobRequest header;
  header.set_sha256(Sha256Hex(bytes));
  header.set_size(static_cast<int64_t>(bytes.size()));
  return header;
}

v1::PutBlobRequest Chunk(const std::string& bytes) {
  v1::PutBlobRequest chunk;
  chunk.set_data(bytes);
  return chunk;
}

// What the service answers to these messages.
grpc::Status Answer(OverGrpc& served,
                    const std::vector<v1::PutBlobRequest>& messages) {
  const auto stub = v1::Checkpoints::NewStub(served.channel);
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(30));
  v1::PutBlobResponse response;
  const auto writer = stub->PutBlob(&context, &response);
  for (const v1::PutBlobRequest& message : messages) writer->Write(message);
  writer->WritesDone();
  return writer->Finish();
}

TEST(CheckpointService, RefusesMalformedUploadsAndStoresNothing) {
  OverGrpc served;
  v1::PutBlobRequest no_digest = Header("x");
  no_digest.set_sha256("../../etc/passwd");
  v1::PutBlobRequest negative = Header("x");
  negative.set_size(-1);
  const std::vector<std::vector<v1::PutBlobRequest>> uploads = {
      {},
      {Chunk("x")},
      {no_digest, Chunk("x")},
      {negative},
      {Header("abc"), Chunk("ab")},
      {Header("abc"), Chunk("abcd")},
      {Header("abc"), Chunk("abd")},
      {Header(std::string(300'000, 'x')), Chunk(std::string(300'000, 'x'))},
  };

  for (size_t i = 0; i < uploads.size(); ++i) {
    const grpc::Status status = Answer(served, uploads[i]);

    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT)
        << i << " " << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr("expected")) << i;
  }
  EXPECT_EQ(served.memory.bytes(), 0);
}

TEST(CheckpointService, RefusesABlobOverItsLimit) {
  OverGrpc served({.max_blob_bytes = 3});

  EXPECT_THAT(served.store().PutBlob(MakeBlob("four")),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("expected 0 to 3 bytes, found 4")));
}

TEST(CheckpointService, BoundsTheBytesOfUploadsInFlight) {
  OverGrpc served({.max_blob_bytes = 100, .max_upload_bytes = 3},
                  {.peer = "checkpoint test", .attempts = 1});

  EXPECT_THAT(served.store().PutBlob(MakeBlob("four")),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("at most 3 bytes, found 0 and 4 more")));
  // Also of bytes that are there: they are read to be compared.
  ASSERT_THAT(served.memory.PutBlob(MakeBlob("four")), IsOk());
  EXPECT_THAT(served.store().PutBlob(MakeBlob("four")),
              StatusIs(absl::StatusCode::kUnavailable));
}

TEST(CheckpointService, CutsAnUploadThatStandsStill) {
  OverGrpc served({.idle_timeout = absl::Milliseconds(50)});
  const auto stub = v1::Checkpoints::NewStub(served.channel);
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(30));
  v1::PutBlobResponse response;
  const auto writer = stub->PutBlob(&context, &response);
  ASSERT_TRUE(writer->Write(Header("abc")));

  // Nothing more is sent.
  const grpc::Status status = writer->Finish();

  EXPECT_EQ(status.error_code(), grpc::StatusCode::CANCELLED);
}

TEST(CheckpointService, TakesNoBytesThatItHas) {
  OverGrpc served;
  const std::string bytes(5 << 20, 'x');
  ASSERT_THAT(served.store().PutBlob(MakeBlob(bytes)), IsOk());

  ASSERT_THAT(served.store().PutBlob(MakeBlob(bytes)), IsOk());

  EXPECT_THAT(served.registry.Text(),
              HasSubstr("sinew_store_received_bytes_total 5242880\n"));
}

TEST(CheckpointService, PassesAFullDiskOn) {
  OverGrpc served;
  served.memory.LimitBytes(3);

  EXPECT_THAT(served.store().PutBlob(MakeBlob("four")),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("checkpoint test: memory: no room")));
}

TEST(CheckpointService, PassesDamagedBytesOn) {
  OverGrpc served;
  const std::string sha256 = *served.store().PutBlob(MakeBlob("abc"));
  served.memory.Damage(sha256);

  EXPECT_THAT(served.store().GetBlob(sha256),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("expected SHA-256 " + sha256)));
  // A client that has the bytes heals them.
  EXPECT_THAT(served.store().PutBlob(MakeBlob("abc")), IsOk());
  EXPECT_THAT(served.store().GetBlob(sha256),
              IsOkAndHolds(Pointee(std::string("abc"))));
}

// Has no blob in memory as a whole.
class OpensOnly : public MemoryStore {
 public:
  absl::StatusOr<Blob> GetBlob(const std::string& /*sha256*/) override {
    return absl::ResourceExhaustedError("too large for memory");
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& sha256) override {
    absl::StatusOr<Blob> blob = MemoryStore::GetBlob(sha256);
    if (!blob.ok()) return blob.status();
    return std::make_unique<WholeBlobReader>(*std::move(blob));
  }
};

TEST(CheckpointService, NeedsNoWholeBlobsForDownloads) {
  OpensOnly store;
  const std::string sha256 = *store.PutBlob(MakeBlob("abc"));
  const SystemClock clock;
  metrics::Registry registry({.role = "checkpoint", .build = ""});
  ServiceMetrics metrics(registry);
  CheckpointService service(store, {}, clock, metrics);

  EXPECT_THAT(service.counted_blobs().OpenBlob(sha256), IsOk());

  EXPECT_THAT(registry.Text(), HasSubstr("sinew_store_sent_bytes_total 3\n"));
}

TEST(CheckpointService, ShowsCallsAndBytes) {
  OverGrpc served;
  const std::string sha256 = *served.store().PutBlob(MakeBlob("abc"));
  ASSERT_THAT(served.store().GetBlob(sha256), IsOk());
  ASSERT_FALSE(served.store().GetArtifact("absent").ok());

  const std::string text = served.registry.Text();

  EXPECT_THAT(metrics::Lint(text), IsOk());
  EXPECT_THAT(text, HasSubstr("sinew_store_received_bytes_total 3\n"));
  EXPECT_THAT(text, HasSubstr("sinew_store_sent_bytes_total 3\n"));
  EXPECT_THAT(
      text,
      HasSubstr("sinew_store_calls_total{result=\"failed\",rpc=\"GetArtifact\""
                "} 1\n"));
  EXPECT_THAT(text, HasSubstr("sinew_store_upload_bytes 0\n"));
}

TEST(CheckpointClient, FindsAServiceThatStartsAfterIt) {
  const CheckpointClient::Options options = {
      .peer = "checkpoint test",
      .attempts = 2,
      .backoff = {.initial = absl::Milliseconds(1)}};
  OverGrpc listed({}, options, OverGrpc::First::kClient);
  OverGrpc stored({}, options, OverGrpc::First::kClient);

  EXPECT_THAT(listed.store().ListArtifacts(""), IsOk());
  EXPECT_THAT(stored.store().PutBlob(MakeBlob("x")), IsOk());
}

TEST(CheckpointClient, NamesAPeerThatIsNotThere) {
  CheckpointClient client(*rpc::MakeChannel("unix:/tmp/nobody-listens", {}),
                          {.peer = "checkpoint unix:/tmp/nobody-listens",
                           .connect_timeout = absl::Milliseconds(1)});

  EXPECT_THAT(client.ListArtifacts(""),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("checkpoint unix:/tmp/nobody-listens")));
  EXPECT_THAT(client.PutBlob(MakeBlob("x")),
              StatusIs(absl::StatusCode::kUnavailable));
}

TEST(CheckpointClient, GivesUpWhenStopped) {
  std::stop_source stop;
  stop.request_stop();
  CheckpointClient client(*rpc::MakeChannel("unix:/tmp/nobody-listens", {}),
                          {.peer = "checkpoint", .stop = stop.get_token()});

  EXPECT_THAT(client.PutBlob(MakeBlob("x")),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(client.Retain("state", 1),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(CheckpointClient, GivesUpOnAServiceThatHangs) {
  OverGrpc served({}, {.peer = "checkpoint test",
                       .idle_timeout = absl::Milliseconds(50),
                       .attempts = 1});
  served.memory.Pause();

  EXPECT_THAT(served.store().PutBlob(MakeBlob("x")),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("checkpoint test: blob " + Sha256Hex("x"))));
  served.memory.Resume();
}

TEST(CheckpointClient, SendsNoBlobOverItsLimit) {
  OverGrpc served({}, {.peer = "checkpoint test", .max_blob_bytes = 3});

  EXPECT_THAT(served.store().PutBlob(MakeBlob("four")),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("at most 3 bytes, found 4")));
}

}  // namespace
}  // namespace sinew::checkpoint
