#include "common/policy/safetensors_header.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"
#include "nlohmann/json.hpp"

namespace sinew::internal {
namespace {

struct TypeInfo {
  v1::DataType dtype;
  absl::string_view name;
  int64_t size;
};

constexpr TypeInfo kTypes[] = {
    {v1::DATA_TYPE_FLOAT32, "F32", 4}, {v1::DATA_TYPE_FLOAT64, "F64", 8},
    {v1::DATA_TYPE_INT32, "I32", 4},   {v1::DATA_TYPE_INT64, "I64", 8},
    {v1::DATA_TYPE_UINT8, "U8", 1},
};

// A name from outside, fit for a message.
std::string Quoted(absl::string_view name) {
  constexpr size_t kLongest = 80;
  std::string text = absl::CHexEscape(name.substr(0, kLongest));
  return absl::StrCat("\"", text, name.size() > kLongest ? "...\"" : "\"");
}

// Takes the JSON apart as it is read, so that no document tree is built and
// only what a header may contain is accepted.
class HeaderReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  std::vector<SafetensorsEntry> entries;
  std::string error;

  bool null() override { return Value("null"); }
  bool boolean(bool) override { return Value("a boolean"); }
  bool number_float(number_float_t, const string_t& text) override {
    return Value(absl::StrCat("the number ", text.substr(0, 40)));
  }
  bool binary(binary_t&) override { return Value("binary data"); }
  bool number_integer(number_integer_t value) override {
    return Value(absl::StrCat("the number ", value));
  }
  bool number_unsigned(number_unsigned_t value) override;
  bool string(string_t& value) override;
  bool start_object(std::size_t) override;
  bool key(string_t& name) override;
  bool end_object() override;
  bool start_array(std::size_t) override;
  bool end_array() override;
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception&) override {
    error = absl::StrCat("no valid JSON at byte ", position, " of the header");
    return false;
  }

 private:
  // What the next token may be.
  enum class State {
    kStart,     // the opening brace
    kTensors,   // a tensor's name
    kTensor,    // a tensor's object
    kFields,    // a field's name
    kType,      // dtype
    kShape,     // the array of extents, or its elements
    kOffsets,   // the array of offsets, or its elements
    kMetadata,  // the object of metadata
    kPairs,     // a metadata key
    kText,      // a metadata value
    kEnd,
  };

  bool Fail(std::string what) {
    error = std::move(what);
    if (!entry_.name.empty()) {
      error = absl::StrCat("tensor ", Quoted(entry_.name), ": ", error);
    }
    return false;
  }
  bool Value(absl::string_view found) {
    return Fail(absl::StrCat("expected ", Expected(), ", found ", found));
  }
  absl::string_view Expected() const;
  bool FinishTensor();

  State state_ = State::kStart;
  bool in_array_ = false;
  SafetensorsEntry entry_;
  std::optional<std::vector<int64_t>> shape_;
  std::optional<std::vector<int64_t>> offsets_;
  std::set<std::string> names_;
};

absl::string_view HeaderReader::Expected() const {
  switch (state_) {
    case State::kStart:
    case State::kTensors:
    case State::kEnd:
      return "one object of tensors";
    case State::kTensor:
    case State::kFields:
      return "an object with dtype, shape and data_offsets";
    case State::kType:
      return "dtype as a string";
    case State::kShape:
      return "shape as an array of integers >= 0";
    case State::kOffsets:
      return "data_offsets as an array of two integers >= 0";
    case State::kMetadata:
    case State::kPairs:
    case State::kText:
      return "__metadata__ as an object of strings";
  }
  return "";
}

bool HeaderReader::number_unsigned(number_unsigned_t value) {
  const bool wanted =
      in_array_ && (state_ == State::kShape || state_ == State::kOffsets);
  if (!wanted || value > static_cast<uint64_t>(INT64_MAX)) {
    return Value(absl::StrCat("the number ", value));
  }
  auto& list = state_ == State::kShape ? *shape_ : *offsets_;
  const size_t most = state_ == State::kShape ? kMaxSafetensorsRank : 2;
  if (list.size() == most) {
    return Fail(absl::StrCat("expected at most ", most,
                             state_ == State::kShape ? " extents" : " offsets",
                             ", found more"));
  }
  list.push_back(static_cast<int64_t>(value));
  return true;
}

bool HeaderReader::string(string_t& value) {
  if (state_ == State::kText) {
    state_ = State::kPairs;
    return true;
  }
  if (state_ != State::kType) return Value("a string");
  for (const TypeInfo& type : kTypes) {
    if (type.name == value) entry_.dtype = type.dtype;
  }
  if (entry_.dtype == v1::DATA_TYPE_UNSPECIFIED) {
    return Fail(absl::StrCat("expected dtype F32, F64, I32, I64 or U8, found ",
                             Quoted(value)));
  }
  state_ = State::kFields;
  return true;
}

bool HeaderReader::start_object(std::size_t) {
  switch (state_) {
    case State::kStart:
      state_ = State::kTensors;
      return true;
    case State::kTensor:
      state_ = State::kFields;
      return true;
    case State::kMetadata:
      state_ = State::kPairs;
      return true;
    default:
      return Value("an object");
  }
}

bool HeaderReader::key(string_t& name) {
  if (state_ == State::kPairs) {
    state_ = State::kText;
    return true;
  }
  if (state_ == State::kTensors) {
    if (!names_.insert(name).second) {
      return Fail(absl::StrCat("tensor ", Quoted(name), " appears twice"));
    }
    if (name == "__metadata__") {
      state_ = State::kMetadata;
      return true;
    }
    if (name.empty()) return Fail("a tensor has an empty name");
    entry_.name = name;
    state_ = State::kTensor;
    return true;
  }
  bool twice = false;
  if (name == "dtype") {
    twice = entry_.dtype != v1::DATA_TYPE_UNSPECIFIED;
    state_ = State::kType;
  } else if (name == "shape") {
    twice = shape_.has_value();
    state_ = State::kShape;
  } else if (name == "data_offsets") {
    twice = offsets_.has_value();
    state_ = State::kOffsets;
  } else {
    return Fail(
        absl::StrCat("expected fields dtype, shape and data_offsets, "
                     "found ",
                     Quoted(name)));
  }
  return !twice || Fail(absl::StrCat("field ", name, " appears twice"));
}

bool HeaderReader::end_object() {
  switch (state_) {
    case State::kFields:
      return FinishTensor();
    case State::kPairs:
      state_ = State::kTensors;
      return true;
    default:
      state_ = State::kEnd;
      return true;
  }
}

bool HeaderReader::start_array(std::size_t) {
  const bool wanted = state_ == State::kShape || state_ == State::kOffsets;
  if (!wanted || in_array_) return Value("an array");
  in_array_ = true;
  (state_ == State::kShape ? shape_ : offsets_).emplace();
  return true;
}

bool HeaderReader::end_array() {
  in_array_ = false;
  state_ = State::kFields;
  return true;
}

bool HeaderReader::FinishTensor() {
  if (entry_.dtype == v1::DATA_TYPE_UNSPECIFIED) {
    return Fail("field dtype is missing");
  }
  if (!shape_) return Fail("field shape is missing");
  if (!offsets_) return Fail("field data_offsets is missing");
  if (offsets_->size() != 2) {
    return Fail(
        absl::StrCat("expected two data_offsets, found ", offsets_->size()));
  }
  entry_.shape = *std::move(shape_);
  entry_.begin = (*offsets_)[0];
  entry_.end = (*offsets_)[1];
  entries.push_back(std::move(entry_));
  entry_ = SafetensorsEntry();
  shape_.reset();
  offsets_.reset();
  state_ = State::kTensors;
  return true;
}

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

int64_t DataTypeSize(v1::DataType dtype) {
  for (const TypeInfo& type : kTypes) {
    if (type.dtype == dtype) return type.size;
  }
  return 0;
}

absl::string_view SafetensorsTypeName(v1::DataType dtype) {
  for (const TypeInfo& type : kTypes) {
    if (type.dtype == dtype) return type.name;
  }
  return "";
}

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
