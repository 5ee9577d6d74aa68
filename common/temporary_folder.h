#ifndef SINEW_COMMON_TEMPORARY_FOLDER_H_
#define SINEW_COMMON_TEMPORARY_FOLDER_H_

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace sinew {

// A new folder that only this user may enter, with a path short enough for a
// unix socket in it; removed at the end with all that it holds.
//
// Thread-safety: immutable. Ownership: owns the folder. Blocking: on the disk.
// Errors: Create: the system's own, naming the path.
class TemporaryFolder {
 public:
  static absl::StatusOr<std::unique_ptr<TemporaryFolder>> Create();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}

  const std::string path_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_TEMPORARY_FOLDER_H_
