#ifndef SINEW_COMMON_REPLACE_DIRECTORY_H_
#define SINEW_COMMON_REPLACE_DIRECTORY_H_

#include <string>

#include "absl/status/status.h"

namespace sinew {

// Puts folder `from`, with all that it holds, in the place of `to` (on the same
// disk), whose former content is removed; `from` is gone then. At any moment,
// and after a crash, `to` is the old folder or the new one. Where the file
// system cannot exchange two names, a crash between two renames leaves the old
// one as `to`.old instead.
//
// Thread-safety: one caller per folder. Blocking: on the disk. Errors: name the
// path and the operating system's reason; `to` is what it was.
absl::Status ReplaceDirectory(const std::string& from, const std::string& to);

}  // namespace sinew

#endif  // SINEW_COMMON_REPLACE_DIRECTORY_H_
