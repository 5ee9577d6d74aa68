// Blobs over the wire.
#include "common/blobs/blobs_service.h"

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/blobs/blob_client.h"
#include "common/blobs/blob_reader.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blob_source.h"
#include "common/digest.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/retry.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/refused_channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Pointee;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

// Large enough for several chunks.
std::string LargeBytes() {
  std::string bytes;
  for (int i = 0; static_cast<int64_t>(bytes.size()) < 3 * rpc::kChunkBytes;
       ++i) {
    bytes += std::to_string(i);
  }
  return bytes;
}

// Gives other bytes than it was asked for.
class Liar : public BlobSource {
 public:
  absl::StatusOr<Blob> GetBlob(const std::string& /*sha256*/) override {
    return std::make_shared<const std::string>("other bytes");
  }
};

// A blob of 1 TiB, which only fits piece by piece; opened once.
class VastSource : public BlobSource {
 public:
  static constexpr int64_t kSize = int64_t{1} << 40;

  absl::StatusOr<Blob> GetBlob(const std::string& /*sha256*/) override {
    return absl::ResourceExhaustedError("too large for memory");
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& /*sha256*/) override {
    return std::make_unique<Reader>(*this);
  }
  // Whether nobody reads it any more.
  bool IsClosedInTime() {
    return closed_.get_future().wait_for(std::chrono::seconds(20)) ==
           std::future_status::ready;
  }

 private:
  class Reader : public BlobReader {
   public:
    explicit Reader(VastSource& source) : source_(source) {}
    ~Reader() override { source_.closed_.set_value(); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    int64_t size() const override { return kSize; }
    absl::StatusOr<absl::string_view> Read(int64_t /*offset*/,
                                           int64_t max_bytes) override {
      piece_.resize(max_bytes);
      return piece_;
    }

   private:
    VastSource& source_;
    std::string piece_;
  };

  std::promise<void> closed_;
};

// Serves a source on a socket and has a client for it.
struct Served {
  explicit Served(BlobSource& source, BlobClient::Options options = {},
                  absl::Duration idle_timeout = absl::Seconds(60))
      : service(source, idle_timeout) {
    auto started =
        rpc::Server::Start({.address = folder.Address("b")}, {&service});
    EXPECT_THAT(started, IsOk());
    server = *std::move(started);
    options.peer = "learner";
    client = std::make_unique<BlobClient>(
        *rpc::MakeChannel(server->address(), {}), std::move(options));
  }

  rpc::SocketFolder folder;
  BlobsService service;
  std::unique_ptr<rpc::Server> server;
  std::unique_ptr<BlobClient> client;
};

TEST(BlobClient, FetchesEmptySmallAndLargeBlobs) {
  BlobRing ring(8);
  Served served(ring);

  for (const std::string& bytes :
       {std::string(), std::string("x"), LargeBytes()}) {
    EXPECT_THAT(served.client->GetBlob(ring.Put(bytes)),
                IsOkAndHolds(Pointee(bytes)));
  }
}

TEST(BlobClient, NamesPeerAndDigestOfWhatIsNotThere) {
  BlobRing ring(8);
  Served served(ring);
  const std::string sha256 = Sha256Hex("absent");

  EXPECT_THAT(served.client->GetBlob(sha256),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("learner: blob " + sha256)));
}

TEST(BlobClient, RefusesBytesThatDoNotMatch) {
  Liar liar;
  Served served(liar);
  const std::string sha256 = Sha256Hex("bytes");

  EXPECT_THAT(served.client->GetBlob(sha256),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr(Sha256Hex("other bytes"))));
}

TEST(BlobClient, RefusesABlobOverItsLimitBeforeAllocating) {
  BlobRing ring(8);
  Served served(ring, {.peer = "", .max_bytes = 3});
  const std::string sha256 = ring.Put("four");

  EXPECT_THAT(served.client->GetBlob(sha256),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("at most 3 bytes, found 4")));
}

TEST(BlobClient, FindsAPeerThatStartsAfterIt) {
  BlobRing ring(8);
  BlobsService service(ring);
  const rpc::SocketFolder folder;
  BlobClient client(rpc::RefusedChannel(folder.Address("b")),
                    {.peer = "learner",
                     .attempts = 2,
                     .backoff = {.initial = absl::Milliseconds(1)}});
  const auto server =
      rpc::Server::Start({.address = folder.Address("b")}, {&service});
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(client.GetBlob(ring.Put("x")),
              IsOkAndHolds(Pointee(std::string("x"))));
}

TEST(BlobClient, NamesAPeerThatIsNotThere) {
  BlobClient client(
      *rpc::MakeChannel("unix:/tmp/nobody-listens-here", {}),
      {.peer = "learner", .connect_timeout = absl::Milliseconds(1)});

  EXPECT_THAT(client.GetBlob(Sha256Hex("x")),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("learner")));
}

// Sends one chunk and no more until it is told that nobody listens.
class HangingBlobs : public v1::Blobs::Service {
 public:
  grpc::Status GetBlob(grpc::ServerContext* context,
                       const v1::GetBlobRequest* /*request*/,
                       grpc::ServerWriter<v1::BlobChunk>* writer) override {
    v1::BlobChunk chunk;
    chunk.set_total_size(10);
    chunk.set_data("abc");
    writer->Write(chunk);
    while (!context->IsCancelled()) {
      rpc::WaitFor(absl::Milliseconds(1), std::stop_token());
    }
    return grpc::Status::CANCELLED;
  }
};

TEST(BlobClient, GivesUpOnAPeerThatHangs) {
  HangingBlobs service;
  const rpc::SocketFolder folder;
  const auto server =
      rpc::Server::Start({.address = folder.Address("b")}, {&service});
  ASSERT_THAT(server, IsOk());
  BlobClient client(*rpc::MakeChannel((*server)->address(), {}),
                    {.peer = "learner",
                     .idle_timeout = absl::Milliseconds(50),
                     .attempts = 1});

  EXPECT_THAT(client.GetBlob(Sha256Hex("x")),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       AllOf(HasSubstr("learner: blob"),
                             HasSubstr("nothing for 50ms"))));
}

TEST(BlobClient, GivesUpWhenStopped) {
  BlobRing ring(8);
  std::stop_source stop;
  stop.request_stop();
  BlobClient client(*rpc::MakeChannel("unix:/tmp/nobody-listens-here", {}),
                    {.peer = "learner", .stop = stop.get_token()});

  EXPECT_THAT(client.GetBlob(Sha256Hex("x")),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(BlobsService, ContinuesABrokenTransfer) {
  BlobRing ring(8);
  Served served(ring);
  const std::string bytes = LargeBytes();
  const auto stub =
      v1::Blobs::NewStub(*rpc::MakeChannel(served.server->address(), {}));
  v1::GetBlobRequest request;
  request.set_sha256(ring.Put(bytes));
  request.set_offset(static_cast<int64_t>(bytes.size()) - 5);
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(20));
  const auto reader = stub->GetBlob(&context, request);
  v1::BlobChunk chunk;

  ASSERT_TRUE(reader->Read(&chunk));

  EXPECT_EQ(chunk.data(), bytes.substr(bytes.size() - 5));
  EXPECT_EQ(chunk.total_size(), static_cast<int64_t>(bytes.size()));
  EXPECT_FALSE(reader->Read(&chunk));
  EXPECT_TRUE(reader->Finish().ok());
}

TEST(BlobsService, ReadsOnlyWhatItSends) {
  VastSource source;
  Served served(source);
  const auto stub =
      v1::Blobs::NewStub(*rpc::MakeChannel(served.server->address(), {}));
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(20));
  const auto reader = stub->GetBlob(&context, v1::GetBlobRequest());
  v1::BlobChunk chunk;

  ASSERT_TRUE(reader->Read(&chunk));
  EXPECT_EQ(chunk.total_size(), VastSource::kSize);
  EXPECT_EQ(chunk.data().size(), rpc::kChunkBytes);
  ASSERT_TRUE(reader->Read(&chunk));

  context.TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST(BlobsService, CutsADownloadThatStandsStill) {
  VastSource source;
  Served served(source, {}, /*idle_timeout=*/absl::Milliseconds(50));
  const auto stub =
      v1::Blobs::NewStub(*rpc::MakeChannel(served.server->address(), {}));
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(20));
  const auto reader = stub->GetBlob(&context, v1::GetBlobRequest());

  // Nothing is read.
  ASSERT_TRUE(source.IsClosedInTime());

  v1::BlobChunk chunk;
  while (reader->Read(&chunk)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST(BlobsService, RefusesAnOffsetBeyondTheEnd) {
  BlobRing ring(8);
  Served served(ring);
  const auto stub =
      v1::Blobs::NewStub(*rpc::MakeChannel(served.server->address(), {}));
  v1::GetBlobRequest request;
  request.set_sha256(ring.Put("abc"));
  request.set_offset(4);
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(20));

  const grpc::Status status = stub->GetBlob(&context, request)->Finish();

  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("[0, 3], found 4"));
}

}  // namespace
}  // namespace sinew
