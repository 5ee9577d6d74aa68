#include "sim/import/formats/npy.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/status_macros.h"

namespace sinew::import {
namespace {

using Kind = NpyHeader::Kind;

// The machine is little-endian, as the build's target is.
template <typename T>
T Load(const char* item, bool big_endian) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, item, sizeof(T));
  if (big_endian) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

double LoadFloat(const char* item, int64_t size, bool big_endian) {
  if (size == 8) return Load<double>(item, big_endian);
  if (size == 4) return Load<float>(item, big_endian);
  return Eigen::numext::bit_cast<Eigen::half>(Load<uint16_t>(item, big_endian));
}

template <typename T1, typename T2, typename T4, typename T8>
double LoadWhole(const char* item, int64_t size, bool big_endian) {
  if (size == 8) return static_cast<double>(Load<T8>(item, big_endian));
  if (size == 4) return Load<T4>(item, big_endian);
  if (size == 2) return Load<T2>(item, big_endian);
  return Load<T1>(item, big_endian);
}

// Appends a Unicode character as UTF-8; false if there is none of that number.
bool AppendUtf8(uint32_t c, std::string* text) {
  if (c > 0x10FFFF || (c >= 0xD800 && c < 0xE000)) return false;
  const auto add = [text](uint32_t byte) {
    text->push_back(static_cast<char>(byte));
  };
  if (c < 0x80) {
    add(c);
  } else if (c < 0x800) {
    add(0xC0 | c >> 6);
    add(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    add(0xE0 | c >> 12);
    add(0x80 | (c >> 6 & 0x3F));
    add(0x80 | (c & 0x3F));
  } else {
    add(0xF0 | c >> 18);
    add(0x80 | (c >> 12 & 0x3F));
    add(0x80 | (c >> 6 & 0x3F));
    add(0x80 | (c & 0x3F));
  }
  return true;
}

}  // namespace

absl::StatusOr<NpyArray> NpyArray::Parse(std::string bytes,
                                         absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(NpyHeader header, ParseNpyHeader(bytes, source));
  if (header.total_bytes() != static_cast<int64_t>(bytes.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected ", header.total_bytes(), " bytes for ",
                     header.ToString(), ", found ", bytes.size()));
  }
  return NpyArray(std::move(header), std::move(bytes));
}

double NpyArray::Number(int64_t index) const {
  SINEW_CHECK(!header_.is_text() && index >= 0 && index < count());
  int64_t at = index;
  if (header_.fortran_order) {
    at = 0;
    int64_t stride = count();
    for (size_t i = shape().size(); i > 0; --i) {
      stride /= shape()[i - 1];
      at += index % shape()[i - 1] * stride;
      index /= shape()[i - 1];
    }
  }
  const int64_t size = header_.item_bytes;
  const char* item = bytes_.data() + header_.data_offset + at * size;
  const bool big_endian = header_.big_endian;
  switch (header_.kind) {
    case Kind::kFloat:
      return LoadFloat(item, size, big_endian);
    case Kind::kInt:
      return LoadWhole<int8_t, int16_t, int32_t, int64_t>(item, size,
                                                          big_endian);
    default:
      return LoadWhole<uint8_t, uint16_t, uint32_t, uint64_t>(item, size,
                                                              big_endian);
  }
}

absl::StatusOr<std::string> NpyArray::Text(absl::string_view source) const {
  if (!header_.is_text() || count() != 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected one text, found ", header_.ToString()));
  }
  const absl::string_view item =
      absl::string_view(bytes_).substr(header_.data_offset);
  std::string text;
  if (header_.kind == Kind::kBytes) {
    text = std::string(item);
  } else {
    for (size_t i = 0; i + 4 <= item.size(); i += 4) {
      const uint32_t c = Load<uint32_t>(&item[i], header_.big_endian);
      if (!AppendUtf8(c, &text)) {
        return absl::InvalidArgumentError(absl::StrCat(
            source, ": expected text, found character number ", c));
      }
    }
  }
  // Padded with zeros.
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}

}  // namespace sinew::import
