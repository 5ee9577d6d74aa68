#include "common/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"

namespace sinew {

absl::StatusOr<std::unique_ptr<TemporaryFolder>> TemporaryFolder::Create() {
  // Not TMPDIR: a socket's path has at most 107 bytes.
  std::string path = "/tmp/sinew-XXXXXX";
  if (mkdtemp(path.data()) == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat(path, ": cannot be made"));
  }
  return std::unique_ptr<TemporaryFolder>(new TemporaryFolder(path));
}

TemporaryFolder::~TemporaryFolder() { RemoveRecursively(path_).IgnoreError(); }

}  // namespace sinew
