#include "common/blobs/blob_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

constexpr int64_t kVerifiedBytes = int64_t{1} << 20;

absl::Status Error(int error, const std::string& path) {
  return absl::ErrnoToStatus(error, absl::StrCat("cannot read ", path));
}

class FileReader final : public BlobReader {
 public:
  // Owns the descriptor.
  FileReader(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  ~FileReader() override { close(fd_); }
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  absl::Status Look() {
    struct stat info;
    if (fstat(fd_, &info) != 0) return Error(errno, path_);
    if (!S_ISREG(info.st_mode)) {
      return absl::FailedPreconditionError(
          absl::StrCat("cannot read ", path_, ": not a regular file"));
    }
    size_ = info.st_size;
    return absl::OkStatus();
  }

  int64_t size() const override { return size_; }

  absl::StatusOr<absl::string_view> Read(int64_t offset,
                                         int64_t max_bytes) override {
    piece_.resize(std::min(max_bytes, size_ - offset));
    size_t got = 0;
    while (got < piece_.size()) {
      const ssize_t more = pread(fd_, piece_.data() + got, piece_.size() - got,
                                 offset + static_cast<int64_t>(got));
      if (more < 0 && errno == EINTR) continue;
      if (more < 0) return Error(errno, path_);
      if (more == 0) {
        return absl::DataLossError(
            absl::StrCat(path_, ": expected ", size_, " bytes, found fewer"));
      }
      got += more;
    }
    return piece_;
  }

 private:
  const std::string path_;
  const int fd_;
  int64_t size_ = 0;
  std::string piece_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlobFile(
    const std::string& path, const std::string& sha256) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return Error(errno, path);
  auto reader = std::make_unique<FileReader>(path, fd);
  SINEW_RETURN_IF_ERROR(reader->Look());
  Sha256 digest;
  for (int64_t offset = 0; offset < reader->size(); offset += kVerifiedBytes) {
    SINEW_ASSIGN_OR_RETURN(const absl::string_view piece,
                           reader->Read(offset, kVerifiedBytes));
    digest.Update(piece);
  }
  const std::string found = digest.FinishHex();
  if (found == sha256) return reader;
  return absl::DataLossError(absl::StrCat(path, ": expected SHA-256 ", sha256,
                                          ", found ", found, " (",
                                          reader->size(), " bytes)"));
}

}  // namespace sinew
