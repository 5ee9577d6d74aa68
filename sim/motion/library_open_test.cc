#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/mapped_file.h"
#include "common/testing/matchers.h"
#include "sim/motion/library.h"
#include "sim/motion/testing/sample_library.h"

namespace sinew::motion {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::Files;
using testing::Folder;
using testing::GoodFiles;
using ::testing::HasSubstr;
using testing::kFrames;
using testing::MakeSample;
using testing::Sample;
using testing::SaveAndLoad;

// A folder with these files.
std::string Put(const std::string& name, const Files& files) {
  EXPECT_THAT(MakeDirectories(Folder(name)), IsOk());
  EXPECT_THAT(WriteFileAtomically(JoinPath(Folder(name), "frames.safetensors"),
                                  files.frames),
              IsOk());
  EXPECT_THAT(WriteFileAtomically(JoinPath(Folder(name), "manifest.json"),
                                  files.manifest),
              IsOk());
  return Folder(name);
}

TEST(Library, OpeningRefusesATruncatedFramesFile) {
  Files files = GoodFiles();
  const size_t whole = files.frames.size();
  for (const size_t size : {size_t{0}, size_t{7}, size_t{100}, whole - 1}) {
    files.frames.resize(size);
    EXPECT_THAT(Library::Load(Put("cut", files)),
                StatusIs(absl::StatusCode::kDataLoss,
                         AllOf(HasSubstr("cut: frames.safetensors: "),
                               HasSubstr("truncated, altered"))));
    files = GoodFiles();
  }
}

TEST(Library, OpeningRefusesFramesOfALibraryOfAnotherSize) {
  Files files = GoodFiles();
  Sample sample = MakeSample();
  sample.manifest.add_feet("second");
  sample.frames["contact"] = HostTensor::Zeros({2 * kFrames, 2});
  ASSERT_THAT(Library::Save(sample.manifest, sample.frames, Folder("wider")),
              IsOk());
  files.frames = *ReadFile(JoinPath(Folder("wider"), "frames.safetensors"));

  EXPECT_THAT(Library::Load(Put("mixed", files)),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("mixed: tensor contact: expected shape [24, "
                                 "1], found [24, 2]")));
}

TEST(Library, VerifyFindsWhatOpeningCannotSee) {
  Files files = GoodFiles();
  files.frames.back() = static_cast<char>(files.frames.back() ^ 1);

  const auto library = Library::Load(Put("altered", files));

  ASSERT_THAT(library, IsOk());
  EXPECT_THAT((*library)->Verify(),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("altered: frames.safetensors: expected "
                                 "SHA-256")));
}

TEST(Library, VerifyReadsNumbersAlsoWhereTheDigestIsRight) {
  Files files = GoodFiles();
  const std::string old_digest = Sha256Hex(files.frames);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(files.frames.data() + files.frames.size() - sizeof(nan), &nan,
              sizeof(nan));
  files.manifest = absl::StrReplaceAll(files.manifest,
                                       {{old_digest, Sha256Hex(files.frames)}});

  const auto library = Library::Load(Put("poisoned", files));

  ASSERT_THAT(library, IsOk());
  EXPECT_THAT((*library)->Verify(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("poisoned: clip \"once\" frame 11 ")));
}

TEST(Library, VerifyAcceptsWhatWasSaved) {
  EXPECT_THAT(SaveAndLoad("whole")->Verify(), IsOk());
}

TEST(Library, KeepsItsFramesWhileItIsReplaced) {
  const auto old_library = SaveAndLoad("replaced");
  Sample sample = MakeSample();
  sample.frames["joint_position"].mutable_float32()[0] = 42;

  ASSERT_THAT(Library::Save(sample.manifest, sample.frames, Folder("replaced")),
              IsOk());

  EXPECT_EQ(old_library->frame(0, 0).joint_position[0], 0);
  EXPECT_THAT(old_library->Verify(), IsOk());
  const auto new_library = Library::Load(Folder("replaced"));
  ASSERT_THAT(new_library, IsOk());
  EXPECT_EQ((*new_library)->frame(0, 0).joint_position[0], 42);
  EXPECT_NE((*new_library)->digest(), old_library->digest());
}

TEST(Library, LoadingGivesUpWhereTheManifestIsAnotherAtEachAttempt) {
  const std::string path =
      JoinPath(Put("restless", GoodFiles()), "manifest.json");
  std::filesystem::remove(path);
  // Reads as another text each time.
  std::filesystem::create_symlink("/proc/sys/kernel/random/uuid", path);

  EXPECT_THAT(Library::Load(Folder("restless")),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("restless: expected a library at rest, found "
                                 "another manifest.json at each of 3")));
}

TEST(Library, IsSharedWhereItsFramesAreMapped) {
  const Files files = GoodFiles();
  const std::string folder = Put("shared", files);
  const std::shared_ptr<const MappedFile> frames(
      MappedFile::Open(JoinPath(folder, "frames.safetensors")).value());

  const auto library = Library::FromMapped(files.manifest, frames, "lib");

  ASSERT_THAT(library, IsOk());
  const auto* at =
      reinterpret_cast<const char*>((*library)->frame(0, 0).joint_position);
  EXPECT_GE(at, frames->bytes().data());
  EXPECT_LT(at, frames->bytes().data() + frames->bytes().size());
  EXPECT_EQ((*library)->digest(), Library::Load(folder).value()->digest());
}

TEST(Library, RefusesMappedFramesOfAnotherManifest) {
  Files files = GoodFiles();
  files.frames.back() ^= 1;
  const std::string folder = Put("altered", files);
  const std::shared_ptr<const MappedFile> frames(
      MappedFile::Open(JoinPath(folder, "frames.safetensors")).value());

  EXPECT_THAT(Library::FromMapped(files.manifest, frames, "lib"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("lib")));
}

TEST(Library, HasTheSameDigestMappedAndFromBytes) {
  const auto mapped = SaveAndLoad("good");
  const Files files = GoodFiles();
  const auto copied = Library::FromBytes(files.manifest, files.frames, "lib");
  ASSERT_THAT(copied, IsOk());
  EXPECT_EQ(mapped->digest(), (*copied)->digest());
}

TEST(Library, SaysThatAFramesHeaderOfOddLengthCannotBeMapped) {
  Files files = GoodFiles();
  // One space more in the header moves all numbers by a byte.
  files.frames[0] = static_cast<char>(files.frames[0] + 1);
  files.frames.insert(files.frames.find("]}}") + 3, " ");
  EXPECT_THAT(Library::Load(Put("odd", files)),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("expected data at a multiple of 4 bytes")));
}

// Bytes of a file's pages that are in memory since somebody has read them, by
// whatever way. What a sanitizer keeps for itself does not count.
int64_t ResidentBytes(const std::string& path) {
  const auto file = MappedFile::Open(path);
  EXPECT_THAT(file, IsOk());
  const absl::string_view bytes = (*file)->bytes();
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  std::vector<unsigned char> pages((bytes.size() + page - 1) / page);
  EXPECT_EQ(
      mincore(const_cast<char*>(bytes.data()), bytes.size(), pages.data()), 0);
  return std::count_if(pages.begin(), pages.end(),
                       [](unsigned char flags) { return (flags & 1) != 0; }) *
         static_cast<int64_t>(page);
}

TEST(Library, TenHoursOpenWithoutBeingRead) {
  testing::MakeSparseLibrary(/*hours=*/10, /*clips=*/4000, Folder("long"));
  const std::string frames = JoinPath(Folder("long"), "frames.safetensors");
  ASSERT_GT(*FileSize(frames), 1'300'000'000);

  const auto library = Library::Load(Folder("long"));

  ASSERT_THAT(library, IsOk());
  EXPECT_EQ((*library)->manifest().num_frames(), 1'080'000);
  // The header of the frames, and what the system reads ahead.
  EXPECT_LT(ResidentBytes(frames), 100'000'000);
  EXPECT_EQ((*library)->frame(3999, 269).feedforward_torque[27], 0);
}

}  // namespace
}  // namespace sinew::motion
