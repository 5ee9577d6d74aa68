// The sources of blobs, alone and behind one another.
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "common/blobs/blob_cache.h"
#include "common/blobs/blob_client.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blob_source.h"
#include "common/blobs/blob_sources.h"
#include "common/blobs/blobs_service.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/refused_channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
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

// Gives whatever it was told to, and counts.
class FakeSource : public BlobSource {
 public:
  explicit FakeSource(std::string bytes)
      : blob_(std::make_shared<const std::string>(std::move(bytes))) {}

  absl::StatusOr<Blob> GetBlob(const std::string& /*sha256*/) override {
    ++calls_;
    return blob_;
  }
  int calls() const { return calls_; }

 private:
  const Blob blob_;
  int calls_ = 0;
};

TEST(BlobRing, KeepsTheLatest) {
  BlobRing ring(/*max_blobs=*/2);
  const std::string a = ring.Put("a");
  const std::string b = ring.Put("b");
  EXPECT_EQ(ring.Put("a"), a);  // the newest again
  const std::string c = ring.Put("c");

  EXPECT_THAT(ring.GetBlob(a), IsOkAndHolds(Pointee(std::string("a"))));
  EXPECT_THAT(ring.GetBlob(c), IsOkAndHolds(Pointee(std::string("c"))));
  EXPECT_THAT(ring.GetBlob(b),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(b)));
  EXPECT_THAT(ring.GetBlob("nonsense"),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(BlobSources, AskOneAfterTheOther) {
  BlobRing first(8);
  BlobRing second(8);
  const std::string sha256 = second.Put("x");
  BlobSources both({&first, &second});

  EXPECT_THAT(both.GetBlob(sha256), IsOkAndHolds(Pointee(std::string("x"))));
  EXPECT_THAT(both.GetBlob(Sha256Hex("y")),
              StatusIs(absl::StatusCode::kNotFound));
}

class BlobCacheTest : public ::testing::Test {
 protected:
  const rpc::SocketFolder folder_;
};

TEST_F(BlobCacheTest, AsksItsSourceOnce) {
  FakeSource source("abc");
  const auto cache = BlobCache::Create(folder_.path() + "/new", 100, source);
  ASSERT_THAT(cache, IsOk());

  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT((*cache)->GetBlob(Sha256Hex("abc")),
                IsOkAndHolds(Pointee(std::string("abc"))));
  }

  EXPECT_EQ(source.calls(), 1);
}

TEST_F(BlobCacheTest, MapsWhatItKeeps) {
  FakeSource source("abc");
  const auto cache = BlobCache::Create(folder_.path(), 100, source);
  ASSERT_THAT(cache, IsOk());

  const auto mapped = (*cache)->MapBlob(Sha256Hex("abc"));

  ASSERT_THAT(mapped, IsOk());
  EXPECT_NE(mapped->file, nullptr);
  EXPECT_EQ(mapped->view(), "abc");
  EXPECT_EQ(source.calls(), 1);
}

TEST_F(BlobCacheTest, HandsOverWhatItCannotKeepWithoutFetchingItTwice) {
  FakeSource source("abc");
  const auto cache = BlobCache::Create(folder_.path(), 2, source);
  ASSERT_THAT(cache, IsOk());

  const auto mapped = (*cache)->MapBlob(Sha256Hex("abc"));

  ASSERT_THAT(mapped, IsOk());
  EXPECT_EQ(mapped->file, nullptr);
  EXPECT_EQ(mapped->view(), "abc");
  EXPECT_EQ(source.calls(), 1);
}

TEST_F(BlobCacheTest, FetchesAnewWhatWasAltered) {
  FakeSource source("abc");
  const auto cache = BlobCache::Create(folder_.path(), 100, source);
  ASSERT_THAT(cache, IsOk());
  ASSERT_THAT(
      WriteFileAtomically(JoinPath(folder_.path(), Sha256Hex("abc")), "abX"),
      IsOk());

  EXPECT_THAT((*cache)->GetBlob(Sha256Hex("abc")),
              IsOkAndHolds(Pointee(std::string("abc"))));

  EXPECT_EQ(source.calls(), 1);
}

TEST_F(BlobCacheTest, StaysWithinItsBound) {
  BlobRing source(8);
  const auto cache = BlobCache::Create(folder_.path(), 10, source);
  ASSERT_THAT(cache, IsOk());

  for (const std::string bytes : {"aaaa", "bbbb", "cccc", "dddddddddddd"}) {
    EXPECT_THAT((*cache)->GetBlob(source.Put(bytes)), IsOk());
  }

  EXPECT_EQ(ListDirectory(folder_.path())->size(), 2u);
}

// Serves a source on a socket and has a client for it.
struct Served {
  explicit Served(BlobSource& source, BlobClient::Options options = {})
      : service(source) {
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
  FakeSource liar("other bytes");
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
