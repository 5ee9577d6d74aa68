#include "deploy/checkpoint/folder_files.h"

#include <unistd.h>

#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::checkpoint {
namespace {

namespace fs = std::filesystem;

absl::Status WriteInto(const ArtifactFiles& files, const std::string& folder) {
  for (const auto& [path, blob] : files) {
    const std::string file = JoinPath(folder, path);
    SINEW_RETURN_IF_ERROR(
        MakeDirectories(fs::path(file).parent_path().string()));
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(file, *blob));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ArtifactFiles> ReadFolder(const std::string& folder) {
  SINEW_RETURN_IF_ERROR(ListDirectory(folder).status());
  ArtifactFiles files;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, error);
  for (; !error && it != fs::recursive_directory_iterator();
       it.increment(error)) {
    const std::string path = it->path().string();
    const fs::file_status status = it->symlink_status(error);
    if (error) break;
    if (fs::is_directory(status)) continue;
    if (!fs::is_regular_file(status)) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": expected a regular file, found another thing"));
    }
    SINEW_ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
    files[it->path().lexically_relative(folder).generic_string()] =
        std::make_shared<const std::string>(std::move(bytes));
  }
  if (error) {
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("cannot read ", folder));
  }
  if (!files.empty()) return files;
  return absl::InvalidArgumentError(
      absl::StrCat(folder, ": expected files, found none"));
}

absl::Status WriteFolder(const ArtifactFiles& files,
                         const std::string& folder) {
  const std::string target(absl::StripSuffix(folder, "/"));
  if (FileExists(target)) {
    return absl::AlreadyExistsError(
        absl::StrCat(target, ": expected nothing there, found something"));
  }
  const std::string temporary =
      absl::StrCat(target, ".sinew-tmp-", getpid(), "-0");
  SINEW_RETURN_IF_ERROR(RemoveRecursively(temporary));
  SINEW_RETURN_IF_ERROR(MakeDirectories(temporary));
  absl::Status status = WriteInto(files, temporary);
  std::error_code error;
  if (status.ok()) fs::rename(temporary, target, error);
  if (error) {
    status = absl::ErrnoToStatus(error.value(),
                                 absl::StrCat("cannot make ", target));
  }
  if (!status.ok()) RemoveRecursively(temporary).IgnoreError();
  return status;
}

}  // namespace sinew::checkpoint
