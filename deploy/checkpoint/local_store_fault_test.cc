// What is left of a store when its process or its disk fails at any point.
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/local_store.h"
#include "deploy/checkpoint/testing/faulty_disk.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kFilesPerSave = 2;
// No save needs as many operations.
constexpr int kMaxOperations = 500;

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

absl::Status Put(ArtifactStore& store, const std::string& id) {
  v1::Artifact record;
  record.set_id(id);
  record.set_kind("state");
  return PutFiles(store, record,
                  {{"own", MakeBlob("own of " + id)},
                   {"shared", MakeBlob("shared by all")}});
}

// As the learner does it: the last two stay.
absl::Status Save(ArtifactStore& store, const std::string& id) {
  absl::Status status = Put(store, id);
  if (status.ok()) status = store.SetAlias("latest", id);
  if (status.ok()) status = store.Retain("state", 2);
  return status;
}

std::string NewFolder() {
  static int count = 0;
  const std::string folder = JoinPath(
      ::testing::TempDir(), absl::StrCat("faults-", getpid(), "-", ++count));
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  return folder;
}

const Clock& TestClock() {
  static const SystemClock clock;
  return clock;
}

std::unique_ptr<LocalStore> Open(const std::string& folder) {
  auto store = LocalStore::Open(folder, TestClock());
  EXPECT_THAT(store, IsOk());
  return *std::move(store);
}

// A store with the states s1 and s2.
std::string MakeStore() {
  const std::string folder = NewFolder();
  const auto store = Open(folder);
  EXPECT_THAT(Save(*store, "s1"), IsOk());
  EXPECT_THAT(Save(*store, "s2"), IsOk());
  return folder;
}

// The folder holds these states, their bytes, and nothing else.
void ExpectExactly(const std::string& folder, std::set<std::string> ids) {
  std::set<std::string> blobs = {Sha256Hex("shared by all")};
  for (const std::string& id : ids) blobs.insert(Sha256Hex("own of " + id));
  EXPECT_THAT(*ListDirectory(JoinPath(folder, "artifacts")),
              ElementsAreArray(ids));
  EXPECT_THAT(*ListDirectory(JoinPath(folder, "blobs")),
              ElementsAreArray(blobs));
  EXPECT_THAT(*ListDirectory(JoinPath(folder, "aliases")),
              ElementsAreArray({"latest"}));
}

// Every artifact that is listed is whole; returns their ids.
std::set<std::string> ExpectWhole(ArtifactStore& store) {
  const auto list = store.ListArtifacts("");
  EXPECT_THAT(list, IsOk());
  EXPECT_THAT(list->damaged(), IsEmpty());
  std::set<std::string> ids;
  for (const v1::Artifact& artifact : list->artifacts()) {
    EXPECT_THAT(GetFiles(store, artifact.id()), IsOk());
    ids.insert(artifact.id());
  }
  return ids;
}

// Saves s3 in a child that is killed at disk operation `at`. False: it was
// done before it came so far.
bool SaveInChildKilledAt(const std::string& folder, int at) {
  const pid_t child = fork();
  if (child == 0) {
    ArmDiskFault(DiskFault::kKill, at);
    const auto store = LocalStore::Open(folder, TestClock());
    _exit(store.ok() && Save(**store, "s3").ok() ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0);
    return false;
  }
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  return true;
}

TEST(LocalStoreFaults, AKillAtAnyPointLeavesTheOldOrTheNewState) {
  int at = 0;
  for (bool killed = true; killed && at < kMaxOperations; ++at) {
    SCOPED_TRACE(absl::StrCat("killed at operation ", at));
    const std::string folder = MakeStore();
    killed = SaveInChildKilledAt(folder, at);

    {
      const auto store = Open(folder);
      EXPECT_THAT(ExpectWhole(*store), Contains("s2"));
      EXPECT_THAT(GetFiles(*store, "latest"), IsOk());
      EXPECT_THAT(store->GetArtifact("latest")->id(), AnyOf("s2", "s3"));
      // And whoever comes next can save.
      EXPECT_THAT(Save(*store, "s3"), IsOk());
    }
    ExpectExactly(folder, {"s2", "s3"});
  }
  // Each file and record: create, write, two fsyncs, a rename.
  EXPECT_GT(at, 4 * (kFilesPerSave + 1));
  EXPECT_LT(at, kMaxOperations);
}

TEST(LocalStoreFaults, AFullDiskAtAnyPointLeavesTheOldState) {
  const std::string folder = MakeStore();
  const auto store = Open(folder);
  int at = 0;
  for (bool failed = true; failed && at < kMaxOperations; ++at) {
    SCOPED_TRACE(absl::StrCat("full at operation ", at));
    ArmDiskFault(DiskFault::kNoSpace, at);
    const absl::Status status = Put(*store, "s3");
    DisarmDiskFault();
    failed = !status.ok();
    if (!failed) break;

    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                                 AllOf(HasSubstr("s3"), HasSubstr(folder))));
    EXPECT_THAT(ExpectWhole(*store), Not(Contains("s3")));
    ExpectExactly(folder, {"s1", "s2"});
  }
  EXPECT_GT(at, 6);
  EXPECT_LT(at, kMaxOperations);
  EXPECT_THAT(ExpectWhole(*store), Contains("s3"));
}

TEST(LocalStoreFaults, AFullDiskLeavesTheAliasWhereItWas) {
  const std::string folder = MakeStore();
  const auto store = Open(folder);
  ArmDiskFault(DiskFault::kNoSpace, 0);

  const absl::Status status = store->SetAlias("latest", "s1");
  DisarmDiskFault();

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(store->GetArtifact("latest")->id(), "s2");
}

// Fills a file system of one megabyte. 0: all as it should be; 2: it cannot be
// mounted here; else what went wrong.
int FillASmallDisk(const std::string& folder) {
  if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) {
    return 2;
  }
  // Elsewhere nobody sees the mount.
  mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
  if (mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=1m") != 0) return 2;
  const auto store = LocalStore::Open(folder, TestClock());
  if (!store.ok()) return 3;
  v1::Artifact record;
  record.set_kind("state");
  record.set_id("s1");
  if (!PutFiles(**store, record, {{"own", MakeBlob(std::string(500'000, 'a'))}})
           .ok()) {
    return 4;
  }
  record.set_id("s2");
  const ArtifactFiles large = {{"own", MakeBlob(std::string(900'000, 'b'))}};
  for (int i = 0; i < 2; ++i) {
    const absl::Status status = PutFiles(**store, record, large);
    if (!absl::IsResourceExhausted(status)) return 5;
  }
  if (!GetFiles(**store, "s1").ok()) return 6;
  const ArtifactFiles small = {{"own", MakeBlob(std::string(400'000, 'c'))}};
  return PutFiles(**store, record, small).ok() ? 0 : 7;
}

TEST(LocalStoreFaults, ARealFullDiskLeavesTheOldState) {
  const std::string folder = NewFolder();
  ASSERT_THAT(MakeDirectories(folder), IsOk());
  const pid_t child = fork();
  if (child == 0) _exit(FillASmallDisk(folder));
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "no tmpfs can be mounted here";

  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(LocalStoreFaults, TwoProcessesDoNotWriteOneFolder) {
  const std::string folder = MakeStore();
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto store = LocalStore::Open(folder, TestClock());
    const char done = store.ok() ? 'y' : 'n';
    while (write(ready[1], &done, 1) == 1) pause();
    _exit(1);
  }
  char answer = 0;
  ASSERT_EQ(read(ready[0], &answer, 1), 1);
  ASSERT_EQ(answer, 'y');

  EXPECT_THAT(LocalStore::Open(folder, TestClock()),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(folder),
                             HasSubstr(absl::StrCat("process ", child)))));

  // However its holder dies, the folder is free then.
  kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_THAT(Save(*Open(folder), "s3"), IsOk());
  close(ready[0]);
  close(ready[1]);
}

}  // namespace
}  // namespace sinew::checkpoint
