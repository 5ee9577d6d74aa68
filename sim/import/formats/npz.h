#ifndef SINEW_SIM_IMPORT_FORMATS_NPZ_H_
#define SINEW_SIM_IMPORT_FORMATS_NPZ_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/npy.h"
#include "sim/import/formats/npy_header.h"

// libzip's archive.
struct zip;

namespace sinew::import {

// Named arrays in one file: NumPy's npz, a zip whose members are NAME.npy,
// stored or deflated. Members are read one by one, on demand, so that pickled
// or odd ones that nobody asks for do no harm. What a member says of its size
// is checked against its compressed size (deflate packs 1032 to 1 at best) and
// kNpyMaxBytes before it is inflated.
//
// Thread-safety: one thread at a time. Ownership: borrows the bytes. Blocking:
// never. Errors: INVALID_ARGUMENT naming source and member, expected and found;
// RESOURCE_EXHAUSTED: too large.
class NpzFile {
 public:
  // The directory of the file. INVALID_ARGUMENT: not a zip, or a name twice.
  static absl::StatusOr<NpzFile> Open(absl::string_view bytes,
                                      absl::string_view source);
  NpzFile(NpzFile&&);
  ~NpzFile();

  // `name` without ".npy".
  bool Has(const std::string& name) const { return members_.contains(name); }
  // "betas, gender, poses": for messages.
  std::string Names() const;

  // What an array is, from the start of its member.
  absl::StatusOr<NpyHeader> ReadHeader(const std::string& name) const;
  absl::StatusOr<NpyArray> ReadArray(const std::string& name) const;

  // "walk.npz: poses": how errors name a member.
  std::string Label(const std::string& name) const;

 private:
  struct Closer {
    void operator()(zip* archive) const;
  };

  NpzFile(std::unique_ptr<zip, Closer> archive, absl::string_view source);
  absl::Status Index();
  // The first `limit` bytes of a member, or all of it if it has fewer.
  absl::StatusOr<std::string> ReadMember(const std::string& name,
                                         int64_t limit) const;

  std::unique_ptr<zip, Closer> archive_;
  std::string source_;
  std::map<std::string, int64_t> members_;  // name to index in the archive
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_NPZ_H_
