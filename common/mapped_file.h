#ifndef SINEW_COMMON_MAPPED_FILE_H_
#define SINEW_COMMON_MAPPED_FILE_H_

#include <cstddef>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew {

// The content of a file, mapped read-only: a page is read from the disk when it
// is first touched, and all processes that map the file share one copy of it.
//
// A mapped file must not shrink: who touches a page behind the new end is
// killed (SIGBUS), and no code of ours could prevent it. What
// WriteFileAtomically replaces does not shrink: the new content is a new file,
// and the old one stays as it was until it is unmapped. So files that are
// mapped are never truncated or written in place, only replaced.
//
// Thread-safety: immutable. Ownership: owns the mapping; bytes() ends with it.
// Blocking: Open on the disk, briefly; touching bytes() for the first time
// waits for the disk. Errors: NOT_FOUND, PERMISSION_DENIED,
// FAILED_PRECONDITION (not a regular file), naming the path.
class MappedFile {
 public:
  static absl::StatusOr<std::unique_ptr<const MappedFile>> Open(
      const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  // Begins at a page boundary; empty for an empty file.
  absl::string_view bytes() const {
    return {static_cast<const char*>(address_), size_};
  }

 private:
  MappedFile(void* address, size_t size) : address_(address), size_(size) {}

  void* const address_;  // null for an empty file
  const size_t size_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_MAPPED_FILE_H_
