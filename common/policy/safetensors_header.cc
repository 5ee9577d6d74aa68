#include "common/policy/safetensors_header.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors_reader.h"
#include "common/status_macros.h"
#include "nlohmann/json.hpp"

namespace sinew::internal {
namespace {

// Bytes that dtype and shape ask for; nothing if that overflows.
std::optional<int64_t> NumBytes(const SafetensorsEntry& entry) {
  int64_t bytes = DataTypeSize(entry.dtype);
  for (const int64_t extent : entry.shape) {
    if (__builtin_mul_overflow(bytes, extent, &bytes)) return std::nullopt;
  }
  return bytes;
}

// Sorted entries must tile [0, size).
absl::Status CheckTiling(const std::vector<SafetensorsEntry>& entries,
                         int64_t size, absl::string_view source) {
  int64_t at = 0;
  for (const SafetensorsEntry& entry : entries) {
    const std::string name =
        absl::StrCat(source, ": tensor ", Quoted(entry.name), ": ");
    if (entry.begin != at || entry.end < entry.begin || entry.end > size) {
      return absl::InvalidArgumentError(absl::StrCat(
          name, "expected data_offsets from ", at, " on within ", size,
          " bytes of data, found [", entry.begin, ", ", entry.end, "]"));
    }
    const std::optional<int64_t> bytes = NumBytes(entry);
    if (bytes != entry.end - entry.begin) {
      return absl::InvalidArgumentError(absl::StrCat(
          name, "expected ", bytes ? absl::StrCat(*bytes) : "too many",
          " bytes by dtype and shape, found ", entry.end - entry.begin));
    }
    at = entry.end;
  }
  if (at != size) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected ", at, " bytes of data, found ", size));
  }
  return absl::OkStatus();
}

absl::StatusOr<int64_t> HeaderLength(absl::string_view bytes,
                                     absl::string_view source) {
  if (bytes.size() < 8) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected at least 8 bytes, found ", bytes.size()));
  }
  uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  if (length > bytes.size() - 8) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected a header of at most ", bytes.size() - 8,
        " bytes, found a header length of ", length));
  }
  return static_cast<int64_t>(length);
}

}  // namespace

absl::StatusOr<SafetensorsLayout> ParseSafetensorsLayout(
    absl::string_view bytes, absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(const int64_t length, HeaderLength(bytes, source));
  const absl::string_view header = bytes.substr(8, length);
  HeaderReader reader;
  const bool read = nlohmann::json::sax_parse(header, &reader);
  if (!read || !reader.error.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(source, ": ", reader.error));
  }
  SafetensorsLayout layout;
  layout.data_offset = 8 + length;
  layout.entries = std::move(reader.entries);
  layout.metadata = std::move(reader.metadata);
  std::sort(layout.entries.begin(), layout.entries.end(),
            [](const SafetensorsEntry& a, const SafetensorsEntry& b) {
              return std::pair(a.begin, a.end) < std::pair(b.begin, b.end);
            });
  SINEW_RETURN_IF_ERROR(CheckTiling(
      layout.entries, static_cast<int64_t>(bytes.size()) - layout.data_offset,
      source));
  return layout;
}

}  // namespace sinew::internal
