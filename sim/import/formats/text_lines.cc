#include "sim/import/formats/text_lines.h"

#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace sinew::import {
namespace {

constexpr size_t kMaxQuotedBytes = 40;

bool IsReadable(absl::string_view text) {
  while (!text.empty()) {
    const size_t bytes = CharacterBytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

}  // namespace

size_t CharacterBytes(absl::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
  const size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return 0;
  for (size_t i = 1; i < bytes; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return 0;
  }
  const auto second = static_cast<unsigned char>(text[1]);
  // Overlong forms, surrogates and what lies beyond Unicode.
  if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) ||
      (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f)) {
    return 0;
  }
  return bytes;
}

TextLines::TextLines(absl::string_view bytes)
    : rest_(absl::StripPrefix(bytes, "\xef\xbb\xbf")) {}

bool TextLines::Next() {
  text_ = {};
  if (rest_.empty()) return false;
  const size_t end = rest_.find_first_of("\r\n");
  text_ = absl::StripAsciiWhitespace(rest_.substr(0, end));
  ++number_;
  if (end == absl::string_view::npos) {
    rest_ = {};
  } else {
    const bool is_pair = rest_.substr(end, 2) == "\r\n";
    rest_.remove_prefix(end + (is_pair ? 2 : 1));
  }
  return true;
}

absl::string_view TakeWord(absl::string_view* text) {
  *text = absl::StripLeadingAsciiWhitespace(*text);
  size_t end = 0;
  while (end < text->size() && !absl::ascii_isspace((*text)[end])) ++end;
  const absl::string_view word = text->substr(0, end);
  text->remove_prefix(end);
  return word;
}

absl::Status LineError(absl::string_view source, int64_t line,
                       absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": line ", line, ": ", what));
}

absl::StatusOr<double> ParseNumber(absl::string_view word) {
  double value = 0;
  if (!absl::SimpleAtod(word, &value)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a number, found ", Quoted(word)));
  }
  if (!(std::abs(value) <= kMaxTextNumber)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a finite number of at most ", kMaxTextNumber,
                     " in size, found ", Quoted(word)));
  }
  return value;
}

std::string Quoted(absl::string_view text) {
  const bool is_long = text.size() > kMaxQuotedBytes;
  return absl::StrCat("\"", absl::CHexEscape(text.substr(0, kMaxQuotedBytes)),
                      is_long ? "..." : "", "\"");
}

absl::Status CheckFileSize(absl::string_view bytes, int64_t most,
                           absl::string_view source) {
  if (static_cast<int64_t>(bytes.size()) <= most) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(
      source, ": expected at most ", most, " bytes, found ", bytes.size()));
}

absl::Status CheckRotations(size_t joints, size_t frames, size_t most,
                            absl::string_view source) {
  if (joints * frames <= most) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat(source, ": expected at most ", most,
                   " joints times frames in a file of its size, found more"));
}

absl::StatusOr<std::string> ParseName(absl::string_view text) {
  text = absl::StripAsciiWhitespace(text);
  if (text.empty() || text.size() > kMaxNameBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a name of 1 to ", kMaxNameBytes,
                     " bytes, found ", Quoted(text)));
  }
  return IsReadable(text) ? std::string(text) : absl::CHexEscape(text);
}

}  // namespace sinew::import
