#include "common/replace_directory.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

absl::Status Error(const std::string& from, const std::string& to) {
  const int error = errno;
  return absl::Status(
      absl::ErrnoToStatusCode(error),
      absl::StrCat("cannot put ", from, " in the place of ", to, ": ",
                   std::generic_category().message(error)));
}

absl::Status Rename(const std::string& from, const std::string& to) {
  if (rename(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  return Error(from, to);
}

// For file systems that cannot exchange.
absl::Status ReplaceInTwoSteps(const std::string& from, const std::string& to) {
  const std::string old = absl::StrCat(to, ".old");
  SINEW_RETURN_IF_ERROR(RemoveRecursively(old));
  SINEW_RETURN_IF_ERROR(Rename(to, old));
  if (absl::Status status = Rename(from, to); !status.ok()) {
    status.Update(Rename(old, to));
    return status;
  }
  return RemoveRecursively(old);
}

absl::Status Exchange(const std::string& from, const std::string& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(),
                RENAME_EXCHANGE) == 0) {
    return RemoveRecursively(from);
  }
  if (errno == EINVAL || errno == ENOSYS || errno == EXDEV) {
    return ReplaceInTwoSteps(from, to);
  }
  return Error(from, to);
}

absl::Status SyncParent(const std::string& path) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return Error(folder, path);
  const bool synced = fsync(fd) == 0;
  const absl::Status status = synced ? absl::OkStatus() : Error(folder, path);
  close(fd);
  return status;
}

}  // namespace

absl::Status ReplaceDirectory(const std::string& from, const std::string& to) {
  SINEW_RETURN_IF_ERROR(FileExists(to) ? Exchange(from, to) : Rename(from, to));
  return SyncParent(to);
}

}  // namespace sinew
