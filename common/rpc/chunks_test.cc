#include "common/rpc/chunks.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<int64_t> SizesOf(absl::string_view bytes, int64_t offset) {
  std::vector<int64_t> sizes;
  ForEachChunk(bytes, offset, [&](absl::string_view chunk, bool first) {
    EXPECT_EQ(first, sizes.empty());
    sizes.push_back(static_cast<int64_t>(chunk.size()));
    return true;
  });
  return sizes;
}

TEST(ForEachChunk, CutsAtTheChunkSizeAndSendsEmptyPayloadsOnce) {
  const std::string bytes(2 * kChunkBytes + 3, 'x');

  EXPECT_THAT(SizesOf(bytes, 0), ElementsAre(kChunkBytes, kChunkBytes, 3));
  EXPECT_THAT(SizesOf(bytes, kChunkBytes), ElementsAre(kChunkBytes, 3));
  EXPECT_THAT(SizesOf(bytes, 2 * kChunkBytes + 3), ElementsAre(0));
  EXPECT_THAT(SizesOf("", 0), ElementsAre(0));
}

TEST(ForEachChunk, StopsWhenTheReceiverIsGone) {
  const std::string bytes(3 * kChunkBytes, 'x');
  int sent = 0;

  EXPECT_FALSE(ForEachChunk(
      bytes, 0, [&](absl::string_view, bool) { return ++sent < 2; }));
  EXPECT_EQ(sent, 2);
}

TEST(ChunkAssembler, PutsTogetherWhatWasCut) {
  const std::string bytes = std::string(kChunkBytes, 'a') + "bc";
  ChunkAssembler payload(/*max_bytes=*/1 << 20);

  ASSERT_THAT(payload.Begin(static_cast<int64_t>(bytes.size())), IsOk());
  ForEachChunk(bytes, 0, [&](absl::string_view chunk, bool) {
    EXPECT_FALSE(payload.complete());
    return payload.Append(chunk).ok();
  });

  EXPECT_TRUE(payload.complete());
  EXPECT_EQ(payload.Release(), bytes);
  EXPECT_FALSE(payload.begun());
}

TEST(ChunkAssembler, RefusesSizesBeforeItAllocates) {
  ChunkAssembler payload(/*max_bytes=*/10);

  EXPECT_THAT(payload.Begin(int64_t{1} << 60),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("at most 10 bytes")));
  EXPECT_THAT(payload.Begin(-1), StatusIs(absl::StatusCode::kInvalidArgument,
                                          HasSubstr("found -1")));
  EXPECT_FALSE(payload.begun());
}

TEST(ChunkAssembler, RefusesBytesThatWereNotDeclared) {
  ChunkAssembler payload(/*max_bytes=*/10);

  EXPECT_THAT(payload.Append("x"),
              StatusIs(absl::StatusCode::kInvalidArgument));
  ASSERT_THAT(payload.Begin(2), IsOk());
  EXPECT_THAT(payload.Append("xyz"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected 2 bytes, found 3")));
}

}  // namespace
}  // namespace sinew::rpc
