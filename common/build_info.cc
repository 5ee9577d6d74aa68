#include "common/build_info.h"

#include <string>

#include "absl/status/statusor.h"
#include "common/digest.h"
#include "common/files.h"

namespace sinew {

const std::string& BuildIdentity() {
  // The link names the file that was started, even if it was replaced since.
  static const std::string* const identity = [] {
    const absl::StatusOr<std::string> program = ReadFile("/proc/self/exe");
    return new std::string(program.ok() ? Sha256Hex(*program) : "unknown");
  }();
  return *identity;
}

}  // namespace sinew
