#include "common/blobs/blob_cache.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/logging.h"
#include "common/mapped_file.h"
#include "common/status_macros.h"

namespace sinew {

namespace fs = std::filesystem;

absl::StatusOr<std::unique_ptr<BlobCache>> BlobCache::Create(
    const std::string& folder, int64_t max_bytes, BlobSource& source) {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  return std::unique_ptr<BlobCache>(new BlobCache(folder, max_bytes, source));
}

BlobCache::BlobCache(std::string folder, int64_t max_bytes, BlobSource& source)
    : folder_(std::move(folder)), max_bytes_(max_bytes), source_(source) {}

absl::StatusOr<Blob> BlobCache::Read(const std::string& sha256) const {
  const std::string path = JoinPath(folder_, sha256);
  SINEW_ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
  if (Sha256Hex(bytes) != sha256) {
    return absl::DataLossError(
        absl::StrCat(path, ": the content does not match its name"));
  }
  // Its last use, for MakeRoom.
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  return std::make_shared<const std::string>(std::move(bytes));
}

absl::Status BlobCache::MakeRoom(int64_t extra_bytes) const {
  std::error_code error;
  std::vector<std::tuple<fs::file_time_type, int64_t, fs::path>> files;
  int64_t total = extra_bytes;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(folder_, error)) {
    // A file may go away under our eyes.
    const auto time = entry.last_write_time(error);
    const auto size = static_cast<int64_t>(entry.file_size(error));
    if (error) continue;
    files.emplace_back(time, size, entry.path());
    total += size;
  }
  std::sort(files.begin(), files.end());
  for (const auto& [time, size, path] : files) {
    if (total <= max_bytes_) break;
    SINEW_RETURN_IF_ERROR(RemoveRecursively(path.string()));
    total -= size;
  }
  return absl::OkStatus();
}

absl::Status BlobCache::Write(const std::string& sha256,
                              const Blob& blob) const {
  const auto size = static_cast<int64_t>(blob->size());
  if (size > max_bytes_) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(MakeRoom(size));
  return WriteFileAtomically(JoinPath(folder_, sha256), *blob);
}

absl::StatusOr<Blob> BlobCache::GetBlob(const std::string& sha256) {
  if (!IsSha256Hex(sha256)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a SHA-256, found \"", sha256, "\""));
  }
  absl::StatusOr<Blob> cached = Read(sha256);
  if (cached.ok()) return cached;
  if (!absl::IsNotFound(cached.status())) {
    LogWarning("cached blob is unusable, fetching it anew",
               {{"reason", cached.status().message()}});
  }
  SINEW_ASSIGN_OR_RETURN(Blob blob, source_.GetBlob(sha256));
  const absl::Status written = Write(sha256, blob);
  if (!written.ok()) {
    LogWarning("cannot cache a blob", {{"reason", written.message()}});
  }
  return blob;
}

absl::StatusOr<SharedBytes> BlobCache::MapBlob(const std::string& sha256) {
  SINEW_ASSIGN_OR_RETURN(Blob blob, GetBlob(sha256));
  auto file = MappedFile::Open(JoinPath(folder_, sha256));
  // Too large to be kept, or already removed for another.
  if (!file.ok()) return SharedBytes{.blob = std::move(blob), .file = nullptr};
  return SharedBytes{.blob = nullptr, .file = *std::move(file)};
}

}  // namespace sinew
