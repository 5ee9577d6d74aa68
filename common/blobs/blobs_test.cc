// The sources of blobs, alone and behind one another.
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/blobs/blob_cache.h"
#include "common/blobs/blob_reader.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blob_source.h"
#include "common/blobs/blob_sources.h"
#include "common/digest.h"
#include "common/files.h"
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
  EXPECT_THAT(both.OpenBlob(Sha256Hex("y")),
              StatusIs(absl::StatusCode::kNotFound));
}

// Has no blob in memory as a whole.
class OpensOnly : public BlobSource {
 public:
  absl::StatusOr<Blob> GetBlob(const std::string& /*sha256*/) override {
    return absl::ResourceExhaustedError("too large for memory");
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& /*sha256*/) override {
    return std::make_unique<WholeBlobReader>(
        std::make_shared<const std::string>("x"));
  }
};

TEST(BlobSources, OpenWhatIsTooLargeForMemory) {
  BlobRing first(8);
  OpensOnly second;
  BlobSources both({&first, &second});

  const auto blob = both.OpenBlob(Sha256Hex("x"));

  ASSERT_THAT(blob, IsOk());
  EXPECT_THAT((*blob)->Read(0, 10), IsOkAndHolds(std::string("x")));
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

}  // namespace
}  // namespace sinew
