#include "sim/import/formats/testing/npz_writer.h"

#include <zip.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "common/check.h"

namespace sinew::import::testing {
namespace {

constexpr int kAlignment = 64;  // of the data

template <typename T>
void Append(double value, bool big_endian, std::string* data) {
  const T typed = static_cast<T>(value);
  char bytes[sizeof(T)];
  std::memcpy(bytes, &typed, sizeof(T));
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  data->append(bytes, sizeof(T));
}

void AppendAs(absl::string_view descr, double value, std::string* data) {
  const bool big_endian = descr[0] == '>';
  const absl::string_view type = descr.substr(1);
  if (type == "f4") return Append<float>(value, big_endian, data);
  if (type == "f8") return Append<double>(value, big_endian, data);
  if (type == "i4") return Append<int32_t>(value, big_endian, data);
  if (type == "i8") return Append<int64_t>(value, big_endian, data);
  if (type == "u1") return Append<uint8_t>(value, big_endian, data);
  SINEW_CHECK(false) << "type " << type;
}

}  // namespace

std::string MakeNpy(absl::string_view descr, bool fortran_order,
                    absl::string_view shape, absl::string_view data) {
  std::string text =
      absl::StrCat("{'descr': '", descr,
                   "', 'fortran_order': ", fortran_order ? "True" : "False",
                   ", 'shape': ", shape, ", }");
  while ((10 + text.size() + 1) % kAlignment != 0) text.push_back(' ');
  text.push_back('\n');
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes.push_back(static_cast<char>(text.size() & 0xFF));
  bytes.push_back(static_cast<char>(text.size() >> 8));
  return absl::StrCat(bytes, text, data);
}

std::string MakeNpy(absl::string_view descr, absl::string_view shape,
                    const std::vector<double>& values) {
  std::string data;
  for (const double value : values) AppendAs(descr, value, &data);
  return MakeNpy(descr, /*fortran_order=*/false, shape, data);
}

std::string MakeNpyText(absl::string_view ascii) {
  std::string data;
  for (const char c : ascii) data += std::string({c, 0, 0, 0});
  return MakeNpy(absl::StrCat("<U", ascii.size()), /*fortran_order=*/false,
                 "()", data);
}

std::string MakeNpz(const std::vector<NpzMember>& members, bool deflated) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* buffer =
      zip_source_buffer_create(nullptr, 0, /*freep=*/0, &error);
  SINEW_CHECK(buffer != nullptr);
  zip_source_keep(buffer);
  zip_t* archive =
      zip_open_from_source(buffer, ZIP_CREATE | ZIP_TRUNCATE, &error);
  SINEW_CHECK(archive != nullptr) << zip_error_strerror(&error);
  for (const NpzMember& member : members) {
    const int64_t index = zip_file_add(
        archive, absl::StrCat(member.name, ".npy").c_str(),
        zip_source_buffer(archive, member.bytes.data(), member.bytes.size(),
                          /*freep=*/0),
        ZIP_FL_ENC_UTF_8);
    SINEW_CHECK(index >= 0) << zip_strerror(archive);
    zip_set_file_compression(archive, index,
                             deflated ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
  }
  SINEW_CHECK(zip_close(archive) == 0) << zip_strerror(archive);
  SINEW_CHECK(zip_source_open(buffer) == 0);
  std::string bytes;
  char chunk[4096];
  for (;;) {
    const int64_t got = zip_source_read(buffer, chunk, sizeof(chunk));
    SINEW_CHECK(got >= 0);
    if (got == 0) break;
    bytes.append(chunk, got);
  }
  zip_source_close(buffer);
  zip_source_free(buffer);
  zip_error_fini(&error);
  return bytes;
}

}  // namespace sinew::import::testing
