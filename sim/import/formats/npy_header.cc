#include "sim/import/formats/npy_header.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/status_macros.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Kind = NpyHeader::Kind;

constexpr char kMagic[] = "\x93NUMPY";
constexpr size_t kMagicBytes = 6;
constexpr size_t kMaxDimensions = 4;

// Reads the dictionary of a header: {'descr': '<f4', 'fortran_order': False,
// 'shape': (119, 72), }
class DictionaryReader {
 public:
  DictionaryReader(absl::string_view text, absl::string_view source)
      : text_(text), rest_(text), source_(source) {}

  absl::StatusOr<NpyHeader> Read() {
    NpyHeader header;
    if (!Take('{')) return Error("\"{\"");
    while (!Take('}')) {
      SINEW_ASSIGN_OR_RETURN(const std::string key, ReadString());
      if (!Take(':')) return Error("\":\"");
      SINEW_RETURN_IF_ERROR(ReadValue(key, &header));
      if (!Take(',') && !Peek('}')) return Error("\",\" or \"}\"");
    }
    if (!absl::StripAsciiWhitespace(rest_).empty()) return Error("the end");
    if (!has_descr_ || !has_order_ || !has_shape_) {
      rest_ = text_;
      return Error("the keys descr, fortran_order and shape");
    }
    return header;
  }

 private:
  absl::Status Error(absl::string_view expected) const {
    return absl::InvalidArgumentError(
        absl::StrCat(source_, ": header of the array: expected ", expected,
                     ", found ", Quoted(rest_)));
  }

  void SkipSpace() { rest_ = absl::StripLeadingAsciiWhitespace(rest_); }
  bool Peek(char c) {
    SkipSpace();
    return !rest_.empty() && rest_[0] == c;
  }
  bool Take(char c) {
    if (!Peek(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool TakeWord(absl::string_view word) {
    SkipSpace();
    if (!absl::StartsWith(rest_, word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  absl::StatusOr<std::string> ReadString() {
    const char quote = Peek('"') ? '"' : '\'';
    if (!Take(quote)) return Error("a string");
    const size_t end = rest_.find(quote);
    if (end == absl::string_view::npos) return Error("the end of a string");
    std::string value(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return value;
  }

  absl::Status ReadValue(const std::string& key, NpyHeader* header) {
    bool* has = key == "descr"           ? &has_descr_
                : key == "fortran_order" ? &has_order_
                : key == "shape"         ? &has_shape_
                                         : nullptr;
    if (has == nullptr || *has) {
      return Error("each of the keys descr, fortran_order and shape once");
    }
    *has = true;
    if (has == &has_descr_) return ReadType(header);
    if (has == &has_shape_) return ReadShape(header);
    header->fortran_order = TakeWord("True");
    if (!header->fortran_order && !TakeWord("False")) {
      return Error("True or False");
    }
    return absl::OkStatus();
  }

  absl::Status ReadType(NpyHeader* header) {
    if (Peek('[')) return Error("an array of numbers or text");
    SINEW_ASSIGN_OR_RETURN(const std::string type, ReadString());
    const auto wrong = [&](absl::string_view what) {
      return absl::InvalidArgumentError(absl::StrCat(
          source_, ": expected an array of real numbers or text, found ", what,
          "type ", Quoted(type)));
    };
    if (absl::EndsWith(type, "O")) {
      return wrong("pickled Python objects, ");
    }
    int64_t size = 0;
    if (type.size() < 3 || !absl::StrContains("<>|=", type[0]) ||
        !absl::SimpleAtoi(type.substr(2), &size) || size < 0 ||
        size > kNpyMaxHeaderBytes) {
      return wrong("");
    }
    header->big_endian = type[0] == '>';
    header->item_bytes = size;
    const bool whole = size == 1 || size == 2 || size == 4 || size == 8;
    switch (type[1]) {
      case 'f':
        header->kind = Kind::kFloat;
        return whole && size > 1 ? absl::OkStatus() : wrong("");
      case 'i':
        header->kind = Kind::kInt;
        return whole ? absl::OkStatus() : wrong("");
      case 'u':
        header->kind = Kind::kUnsigned;
        return whole ? absl::OkStatus() : wrong("");
      case 'b':
        header->kind = Kind::kBool;
        return size == 1 ? absl::OkStatus() : wrong("");
      case 'U':
        header->kind = Kind::kUnicode;
        header->item_bytes = 4 * size;
        return absl::OkStatus();
      case 'S':
        header->kind = Kind::kBytes;
        return absl::OkStatus();
      default:
        return wrong("");
    }
  }

  absl::Status ReadShape(NpyHeader* header) {
    if (!Take('(')) return Error("a shape");
    while (!Take(')')) {
      SkipSpace();
      size_t digits = 0;
      while (digits < rest_.size() && absl::ascii_isdigit(rest_[digits])) {
        ++digits;
      }
      int64_t size = 0;
      if (!absl::SimpleAtoi(rest_.substr(0, digits), &size) ||
          size > kNpyMaxBytes) {
        return Error("a size");
      }
      if (header->shape.size() == kMaxDimensions) {
        return Error(absl::StrCat("at most ", kMaxDimensions, " dimensions"));
      }
      header->shape.push_back(size);
      rest_.remove_prefix(digits);
      TakeWord("L");  // as Python 2 wrote it
      if (!Take(',') && !Peek(')')) return Error("\",\" or \")\"");
    }
    return absl::OkStatus();
  }

  const absl::string_view text_;
  absl::string_view rest_;
  const absl::string_view source_;
  bool has_descr_ = false, has_order_ = false, has_shape_ = false;
};

uint32_t LittleEndian(absl::string_view bytes) {
  uint32_t value = 0;
  for (size_t i = bytes.size(); i > 0; --i) {
    value = value << 8 | static_cast<uint8_t>(bytes[i - 1]);
  }
  return value;
}

}  // namespace

int64_t NpyHeader::count() const {
  int64_t count = 1;
  for (const int64_t size : shape) count *= size;
  return count;
}

std::string NpyHeader::ToString() const {
  static constexpr const char* kNames[] = {"float", "int",  "uint",
                                           "bool",  "text", "bytes"};
  std::string name = kNames[static_cast<int>(kind)];
  if (kind < Kind::kBool) absl::StrAppend(&name, 8 * item_bytes);
  return absl::StrCat(name, " (", absl::StrJoin(shape, ", "), ")");
}

absl::StatusOr<NpyHeader> ParseNpyHeader(absl::string_view bytes,
                                         absl::string_view source) {
  const auto error = [source](absl::string_view what) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected a NumPy array, found ", what));
  };
  if (bytes.size() < kMagicBytes + 4 ||
      bytes.substr(0, kMagicBytes) != absl::string_view(kMagic, kMagicBytes)) {
    return error(absl::StrCat("bytes that begin with ",
                              Quoted(bytes.substr(0, kMagicBytes))));
  }
  const int version = bytes[kMagicBytes];
  if (version < 1 || version > 3) {
    return error(absl::StrCat("one of version ", version));
  }
  const size_t length_bytes = version == 1 ? 2 : 4;
  const size_t start = kMagicBytes + 2 + length_bytes;
  if (bytes.size() < start) return error("a truncated header");
  const uint32_t length =
      LittleEndian(bytes.substr(kMagicBytes + 2, length_bytes));
  if (start + length > kNpyMaxHeaderBytes) {
    return error(absl::StrCat("a header of ", length, " bytes"));
  }
  if (bytes.size() < start + length) return error("a truncated header");
  SINEW_ASSIGN_OR_RETURN(
      NpyHeader header,
      DictionaryReader(bytes.substr(start, length), source).Read());
  header.data_offset = static_cast<int64_t>(start + length);
  // The product, without overflow.
  int64_t room = kNpyMaxBytes;
  for (const int64_t size : header.shape) room /= std::max<int64_t>(size, 1);
  // Elements of no bytes (empty text) count as one: their number is bounded
  // too.
  if (room < std::max<int64_t>(header.item_bytes, 1)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected an array of at most ", kNpyMaxBytes,
                     " bytes, found ", header.ToString()));
  }
  return header;
}

}  // namespace sinew::import
