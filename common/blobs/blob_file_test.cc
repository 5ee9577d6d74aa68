#include "common/blobs/blob_file.h"

#include <string>

#include "absl/status/status.h"
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
using ::testing::AllOf;
using ::testing::HasSubstr;

class BlobFile : public ::testing::Test {
 protected:
  void Write(const std::string& bytes) const {
    ASSERT_THAT(WriteFileAtomically(path_, bytes), IsOk());
  }

  const rpc::SocketFolder folder_;
  const std::string path_ = JoinPath(folder_.path(), "blob");
};

TEST_F(BlobFile, ReadsPiecesAndTheEnd) {
  Write("abcde");

  const auto blob = OpenBlobFile(path_, Sha256Hex("abcde"));

  ASSERT_THAT(blob, IsOk());
  EXPECT_EQ((*blob)->size(), 5);
  EXPECT_THAT((*blob)->Read(1, 2), IsOkAndHolds(std::string("bc")));
  EXPECT_THAT((*blob)->Read(3, 100), IsOkAndHolds(std::string("de")));
  EXPECT_THAT((*blob)->Read(5, 1), IsOkAndHolds(std::string()));
}

TEST_F(BlobFile, VerifiesMoreThanOnePiece) {
  std::string bytes(3'000'000, 'x');
  Write(bytes);
  EXPECT_THAT(OpenBlobFile(path_, Sha256Hex(bytes)), IsOk());
  const std::string expected = Sha256Hex(bytes);

  bytes.back() = 'y';
  Write(bytes);

  EXPECT_THAT(
      OpenBlobFile(path_, expected),
      StatusIs(absl::StatusCode::kDataLoss,
               AllOf(HasSubstr(path_), HasSubstr("found " + Sha256Hex(bytes)),
                     HasSubstr("3000000 bytes"))));
}

TEST_F(BlobFile, GoesOnWhenTheFileIsReplacedOrRemoved) {
  Write("abcde");
  const auto blob = OpenBlobFile(path_, Sha256Hex("abcde"));
  ASSERT_THAT(blob, IsOk());

  Write("others");
  EXPECT_THAT((*blob)->Read(0, 100), IsOkAndHolds(std::string("abcde")));
  ASSERT_THAT(RemoveRecursively(path_), IsOk());
  EXPECT_THAT((*blob)->Read(0, 100), IsOkAndHolds(std::string("abcde")));
}

TEST_F(BlobFile, NamesWhatIsNoFile) {
  EXPECT_THAT(OpenBlobFile(path_, Sha256Hex("")),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(path_)));
  EXPECT_THAT(OpenBlobFile(folder_.path(), Sha256Hex("")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr(folder_.path())));
}

}  // namespace
}  // namespace sinew
