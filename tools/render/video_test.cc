#include "tools/render/video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "common/check.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::render {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

absl::StatusOr<Image> Grey(int /*frame*/) { return Image(16, 16); }

// A folder with a stand-in for the encoder: a shell script.
class Video : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = JoinPath(
        ::testing::TempDir(),
        ::testing::UnitTest::GetInstance()->current_test_info()->name());
    ASSERT_THAT(RemoveRecursively(folder_), IsOk());
    ASSERT_THAT(MakeDirectories(folder_), IsOk());
    path_ = JoinPath(folder_, "out.mp4");
  }

  VideoOptions EncoderThat(const std::string& does) {
    VideoOptions options;
    options.encoder = JoinPath(folder_, "encoder");
    SINEW_CHECK(WriteFileAtomically(options.encoder,
                                    "#!/bin/sh\n"
                                    "[ \"$1\" = -version ] && exit 0\n" +
                                        does)
                    .ok());
    SINEW_CHECK(chmod(options.encoder.c_str(), 0755) == 0);
    return options;
  }

  std::string folder_, path_;
};

TEST_F(Video, HandsEveryPictureToTheEncoderAndLeavesOnlyTheFilm) {
  // The seventh argument is the pattern of the pictures; the last is the film.
  const VideoOptions options = EncoderThat(
      "for last; do :; done\n"
      "ls \"$(dirname \"$7\")\" | grep -c png > \"$last\"\n");

  ASSERT_THAT(WriteVideo(5, Grey, path_, options, StopToken()), IsOk());

  EXPECT_THAT(ReadFile(path_), IsOkAndHolds("5\n"));
  EXPECT_THAT(ListDirectory(folder_),
              IsOkAndHolds(ElementsAre("encoder", "out.mp4")));
}

TEST_F(Video, NamesThePackageOfAMissingEncoderBeforeDrawing) {
  VideoOptions options;
  options.encoder = "no-such-encoder";
  int drawn = 0;

  const auto status = WriteVideo(
      5,
      [&](int frame) {
        ++drawn;
        return Grey(frame);
      },
      path_, options, StopToken());

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable,
                               HasSubstr("Debian package ffmpeg")));
  EXPECT_EQ(drawn, 0);
}

TEST_F(Video, TellsWhatAFailingEncoderSaidAndKeepsTheOldFilm) {
  ASSERT_THAT(WriteFileAtomically(path_, "old"), IsOk());
  const VideoOptions options = EncoderThat("echo no codec; exit 3\n");

  EXPECT_THAT(WriteVideo(1, Grey, path_, options, StopToken()),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("exit code 3: no codec")));

  EXPECT_THAT(ReadFile(path_), IsOkAndHolds("old"));
  EXPECT_THAT(ListDirectory(folder_),
              IsOkAndHolds(Not(::testing::Contains("out.mp4.frames"))));
}

TEST_F(Video, StopsWhenAsked) {
  StopSource source;
  source.request_stop();

  EXPECT_THAT(
      WriteVideo(3, Grey, path_, EncoderThat("exit 0\n"), source.get_token()),
      StatusIs(absl::StatusCode::kCancelled, HasSubstr("stopped")));
}

}  // namespace
}  // namespace sinew::render
