#ifndef SINEW_COMMON_FILES_H_
#define SINEW_COMMON_FILES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew {

// File helpers whose errors name the path and the operating system's reason.
// Thread-safe; they block on the disk.

// Whole content. NOT_FOUND, PERMISSION_DENIED, RESOURCE_EXHAUSTED (larger than
// max_bytes; nothing is allocated beyond it).
absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     int64_t max_bytes = int64_t{1} << 34);

// Replaces or creates `path` so that a crash at any point leaves the old or
// the new content: temporary file in the same folder, fsync, rename, fsync of
// the folder. RESOURCE_EXHAUSTED when the disk is full (the temporary file is
// removed, the old content stays). A crash may leave the temporary file, which
// IsTemporaryName() knows.
absl::Status WriteFileAtomically(const std::string& path,
                                 absl::string_view content);

// Before long work whose result WriteFileAtomically(path) will keep: whether
// the folder is there. NOT_FOUND, FAILED_PRECONDITION (not a folder).
absl::Status CheckFolderOf(const std::string& path);

// True for names that WriteFileAtomically gives its temporary files.
bool IsTemporaryName(absl::string_view name);

// Adds `content` to the end of a file, which is created if need be, without
// fsync: a crash of the machine may cut the end.
absl::Status AppendToFile(const std::string& path, absl::string_view content);

// Like mkdir -p.
absl::Status MakeDirectories(const std::string& path);

// Names (not paths) in a folder, sorted.
absl::StatusOr<std::vector<std::string>> ListDirectory(const std::string& path);

// True if something (file or folder) is there and may be looked at.
bool FileExists(const std::string& path);

// Size in bytes. NOT_FOUND, FAILED_PRECONDITION (not a regular file).
absl::StatusOr<int64_t> FileSize(const std::string& path);

// Removes a file, or a folder with all that it holds; OK if nothing is there.
absl::Status RemoveRecursively(const std::string& path);

// Joins with exactly one slash; an empty left gives right.
std::string JoinPath(absl::string_view left, absl::string_view right);

// Keeps other processes, and other holders in this one, from a folder: holds
// an exclusive lock on the file LOCK in it, which names the holder's process.
// The operating system releases it when the process dies, however it dies.
//
// Thread-safety: yes. Blocking: never. Errors: FAILED_PRECONDITION naming the
// folder and the process that holds it.
class DirectoryLock {
 public:
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> Acquire(
      const std::string& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  explicit DirectoryLock(int fd) : fd_(fd) {}

  const int fd_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_FILES_H_
