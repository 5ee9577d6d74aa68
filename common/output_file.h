#ifndef SINEW_COMMON_OUTPUT_FILE_H_
#define SINEW_COMMON_OUTPUT_FILE_H_

#include <string>

#include "absl/status/status.h"

namespace sinew {

// Before long work whose result WriteFileAtomically(path) will keep: whether
// its folder is there and may be written, and no folder has the file's name.
// NOT_FOUND; FAILED_PRECONDITION: something else than a folder, or a folder of
// that name; PERMISSION_DENIED. Thread-safe; looks at the disk.
absl::Status CheckOutputFile(const std::string& path);

}  // namespace sinew

#endif  // SINEW_COMMON_OUTPUT_FILE_H_
