#include "sim/import/formats/npz.h"

#include <zip.h>

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "common/status_macros.h"

namespace sinew::import {
namespace {

// Deflate's best ratio, and room for what never shrinks.
constexpr uint64_t kMaxRatio = 1032;
constexpr uint64_t kRatioSlack = 4096;

struct FileCloser {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using FilePtr = std::unique_ptr<zip_file_t, FileCloser>;

// Refuses what cannot be what it says, or is too large. `label` names it.
absl::Status CheckMember(const zip_stat_t& stat, const std::string& label) {
  constexpr uint64_t kWanted =
      ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
  if ((stat.valid & kWanted) != kWanted) {
    return absl::InvalidArgumentError(
        absl::StrCat(label, ": expected a member of known size, found none"));
  }
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE) {
    return absl::InvalidArgumentError(
        absl::StrCat(label, ": expected a stored or deflated member, found ",
                     "compression method ", stat.comp_method));
  }
  if (stat.size / kMaxRatio > stat.comp_size + kRatioSlack) {
    return absl::InvalidArgumentError(
        absl::StrCat(label, ": expected a size that ", stat.comp_size,
                     " compressed bytes can have, found ", stat.size));
  }
  if (stat.size > static_cast<uint64_t>(kNpyMaxBytes + kNpyMaxHeaderBytes)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(label, ": expected at most ", kNpyMaxBytes,
                     " bytes, found ", stat.size));
  }
  return absl::OkStatus();
}

// Reads until `bytes` is full, and to the end of the member if `whole`: only
// there does libzip compare checksums.
absl::Status Fill(zip_file_t* file, bool whole, const std::string& label,
                  std::string* bytes) {
  size_t read = 0;
  char beyond;
  while (read < bytes->size() + (whole ? 1 : 0)) {
    const bool full = read == bytes->size();
    const int64_t got = zip_fread(file, full ? &beyond : &(*bytes)[read],
                                  full ? 1 : bytes->size() - read);
    if (got < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(label, ": cannot be read: ", zip_file_strerror(file)));
    }
    if (got == 0) break;
    read += got;
  }
  if (read == bytes->size()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(label, ": expected ", bytes->size(), " bytes, found ",
                   read > bytes->size() ? "more" : "fewer"));
}

}  // namespace

void NpzFile::Closer::operator()(zip* archive) const { zip_discard(archive); }

NpzFile::NpzFile(std::unique_ptr<zip, Closer> archive, absl::string_view source)
    : archive_(std::move(archive)), source_(source) {}
NpzFile::NpzFile(NpzFile&&) = default;
NpzFile::~NpzFile() = default;

absl::StatusOr<NpzFile> NpzFile::Open(absl::string_view bytes,
                                      absl::string_view source) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* buffer = zip_source_buffer_create(bytes.data(), bytes.size(),
                                                  /*freep=*/0, &error);
  zip_t* archive = nullptr;
  if (buffer != nullptr) {
    archive = zip_open_from_source(buffer, ZIP_RDONLY, &error);
    if (archive == nullptr) zip_source_free(buffer);
  }
  const std::string reason = zip_error_strerror(&error);
  zip_error_fini(&error);
  if (archive == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected an npz (zip) file, found: ", reason));
  }
  NpzFile file(std::unique_ptr<zip, Closer>(archive), source);
  SINEW_RETURN_IF_ERROR(file.Index());
  return file;
}

absl::Status NpzFile::Index() {
  const int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (int64_t i = 0; i < count; ++i) {
    const char* name = zip_get_name(archive_.get(), i, ZIP_FL_ENC_GUESS);
    if (name == nullptr) continue;
    const std::string member(absl::StripSuffix(name, ".npy"));
    if (!members_.emplace(member, i).second) {
      return absl::InvalidArgumentError(
          absl::StrCat(source_, ": expected each member once, found \"",
                       absl::CHexEscape(member), "\" twice"));
    }
  }
  return absl::OkStatus();
}

std::string NpzFile::Label(const std::string& name) const {
  return absl::StrCat(source_, ": ", name);
}

std::string NpzFile::Names() const {
  constexpr size_t kMaxBytes = 400;
  std::string names =
      absl::StrJoin(members_, ", ", [](std::string* out, const auto& member) {
        absl::StrAppend(out, absl::CHexEscape(member.first));
      });
  if (names.empty()) return "no members";
  if (names.size() > kMaxBytes) names = names.substr(0, kMaxBytes) + " ...";
  return names;
}

absl::StatusOr<std::string> NpzFile::ReadMember(const std::string& name,
                                                int64_t limit) const {
  const auto member = members_.find(name);
  if (member == members_.end()) {
    return absl::InvalidArgumentError(absl::StrCat(
        source_, ": expected a member ", name, ", found ", Names()));
  }
  const std::string label = Label(name);
  zip_stat_t stat;
  FilePtr file;
  if (zip_stat_index(archive_.get(), member->second, 0, &stat) == 0) {
    SINEW_RETURN_IF_ERROR(CheckMember(stat, label));
    file.reset(zip_fopen_index(archive_.get(), member->second, 0));
  }
  if (file == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        label, ": cannot be read: ", zip_strerror(archive_.get())));
  }
  std::string bytes(std::min<int64_t>(limit, stat.size), '\0');
  const bool whole = bytes.size() == stat.size;
  SINEW_RETURN_IF_ERROR(Fill(file.get(), whole, label, &bytes));
  return bytes;
}

absl::StatusOr<NpyHeader> NpzFile::ReadHeader(const std::string& name) const {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadMember(name, kNpyMaxHeaderBytes));
  return ParseNpyHeader(bytes, Label(name));
}

absl::StatusOr<NpyArray> NpzFile::ReadArray(const std::string& name) const {
  SINEW_ASSIGN_OR_RETURN(std::string bytes,
                         ReadMember(name, kNpyMaxBytes + kNpyMaxHeaderBytes));
  return NpyArray::Parse(std::move(bytes), Label(name));
}

}  // namespace sinew::import
