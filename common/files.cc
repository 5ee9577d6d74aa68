#include "common/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

constexpr char kTemporaryMark[] = ".sinew-tmp-";

absl::StatusCode CodeOf(int error) {
  switch (error) {
    // A file size limit and a full disk are one to the caller.
    case EFBIG:
    case ENOSPC:
    case EDQUOT:
      return absl::StatusCode::kResourceExhausted;
    case EROFS:
      return absl::StatusCode::kPermissionDenied;
    case EISDIR:
    case ENOTDIR:
      return absl::StatusCode::kFailedPrecondition;
    default:
      return absl::ErrnoToStatusCode(error);
  }
}

absl::Status Error(int error, const char* what, const std::string& path) {
  return absl::Status(CodeOf(error),
                      absl::StrCat("cannot ", what, " ", path, ": ",
                                   std::generic_category().message(error)));
}

// The folder that a path's last component lies in.
std::string FolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

absl::Status WriteAll(int fd, absl::string_view content,
                      const std::string& path) {
  while (!content.empty()) {
    const ssize_t written = write(fd, content.data(), content.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return Error(errno, "write", path);
    }
    content.remove_prefix(written);
  }
  return absl::OkStatus();
}

// Writes a new file and forces it to the disk.
absl::Status WriteDurably(const std::string& path, absl::string_view content) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                      S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  if (fd < 0) return Error(errno, "create", path);
  absl::Status status = WriteAll(fd, content, path);
  if (status.ok() && fsync(fd) != 0) status = Error(errno, "write", path);
  if (close(fd) != 0 && status.ok()) status = Error(errno, "write", path);
  return status;
}

absl::Status SyncFolder(const std::string& folder) {
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return Error(errno, "open", folder);
  const absl::Cleanup close_fd = [fd] { close(fd); };
  if (fsync(fd) != 0) return Error(errno, "write", folder);
  return absl::OkStatus();
}

// A temporary name that no other writer of this machine uses.
std::string TemporaryPathFor(const std::string& path) {
  static std::atomic<uint64_t> counter = 0;
  return absl::StrCat(path, kTemporaryMark, getpid(), "-",
                      counter.fetch_add(1, std::memory_order_relaxed));
}

absl::StatusOr<struct stat> StatOf(int fd, const std::string& path) {
  struct stat info;
  if (fstat(fd, &info) != 0) return Error(errno, "read", path);
  if (S_ISDIR(info.st_mode)) return Error(EISDIR, "read", path);
  if (!S_ISREG(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read ", path, ": not a regular file"));
  }
  return info;
}

absl::Status TooLarge(const std::string& path, int64_t max_bytes) {
  return absl::ResourceExhaustedError(absl::StrCat(
      "cannot read ", path, ": larger than ", max_bytes, " bytes"));
}

}  // namespace

absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     int64_t max_bytes) {
  // A pipe without a writer would keep a plain open for ever.
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return Error(errno, "read", path);
  const absl::Cleanup close_fd = [fd] { close(fd); };
  SINEW_ASSIGN_OR_RETURN(const struct stat info, StatOf(fd, path));
  if (info.st_size > max_bytes) return TooLarge(path, max_bytes);

  // The size is a hint: files under /proc say 0, others may grow.
  constexpr int64_t kLeastChunk = 4096;
  std::string content;
  int64_t size = 0;
  while (true) {
    const int64_t want =
        std::max<int64_t>(info.st_size + 1 - size, kLeastChunk);
    content.resize(std::min(size + want, max_bytes + 1));
    const ssize_t got = read(fd, content.data() + size, content.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Error(errno, "read", path);
    size += got;
    if (size > max_bytes) return TooLarge(path, max_bytes);
    if (got == 0) break;
  }
  content.resize(size);
  return content;
}

absl::Status WriteFileAtomically(const std::string& path,
                                 absl::string_view content) {
  const std::string temporary = TemporaryPathFor(path);
  absl::Status status = WriteDurably(temporary, content);
  if (status.ok() && rename(temporary.c_str(), path.c_str()) != 0) {
    status = Error(errno, "replace", path);
  }
  if (!status.ok()) {
    unlink(temporary.c_str());
    return status;
  }
  return SyncFolder(FolderOf(path));
}

absl::Status CheckFolderOf(const std::string& path) {
  const std::string folder = FolderOf(path);
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return absl::OkStatus();
  if (FileExists(folder)) {
    return absl::FailedPreconditionError(absl::StrCat(
        path, ": expected ", folder, " to be a folder, found something else"));
  }
  return absl::NotFoundError(absl::StrCat(path, ": expected a folder ", folder,
                                          " to write it in, found none"));
}

bool IsTemporaryName(absl::string_view name) {
  return name.find(kTemporaryMark) != absl::string_view::npos;
}

absl::Status AppendToFile(const std::string& path, absl::string_view content) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC,
                      S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  if (fd < 0) return Error(errno, "append to", path);
  absl::Status status = WriteAll(fd, content, path);
  if (close(fd) != 0 && status.ok()) status = Error(errno, "write", path);
  return status;
}

absl::Status MakeDirectories(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) return Error(error.value(), "create folder", path);
  if (!std::filesystem::is_directory(path, error)) {
    return Error(ENOTDIR, "create folder", path);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> ListDirectory(
    const std::string& path) {
  std::error_code error;
  std::vector<std::string> names;
  std::filesystem::directory_iterator it(path, error);
  const std::filesystem::directory_iterator end;
  while (!error && it != end) {
    names.push_back(it->path().filename().string());
    it.increment(error);
  }
  if (error) return Error(error.value(), "list", path);
  std::sort(names.begin(), names.end());
  return names;
}

bool FileExists(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

absl::StatusOr<int64_t> FileSize(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error) return Error(error.value(), "look at", path);
  if (!std::filesystem::is_regular_file(status)) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot look at ", path, ": not a regular file"));
  }
  const auto size = std::filesystem::file_size(path, error);
  if (error) return Error(error.value(), "look at", path);
  return static_cast<int64_t>(size);
}

absl::Status RemoveRecursively(const std::string& path) {
  std::error_code error;
  std::filesystem::remove_all(path, error);
  if (error) return Error(error.value(), "remove", path);
  return absl::OkStatus();
}

std::string JoinPath(absl::string_view left, absl::string_view right) {
  if (left.empty()) return std::string(right);
  while (absl::EndsWith(left, "/")) left.remove_suffix(1);
  while (absl::StartsWith(right, "/")) right.remove_prefix(1);
  return absl::StrCat(left, "/", right);
}

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::Acquire(
    const std::string& directory) {
  const std::string path = JoinPath(directory, "LOCK");
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC,
                      S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  if (fd < 0) return Error(errno, "lock", path);
  std::unique_ptr<DirectoryLock> lock(new DirectoryLock(fd));
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return Error(errno, "lock", path);
    const absl::StatusOr<std::string> holder = ReadFile(path, /*max_bytes=*/64);
    return absl::FailedPreconditionError(
        absl::StrCat("folder ", directory, " is in use by process ",
                     holder.ok() && !holder->empty() ? *holder : "unknown"));
  }
  if (ftruncate(fd, 0) != 0) return Error(errno, "lock", path);
  SINEW_RETURN_IF_ERROR(WriteAll(fd, absl::StrCat(getpid()), path));
  return lock;
}

DirectoryLock::~DirectoryLock() { close(fd_); }

}  // namespace sinew
