#include "common/policy/safetensors_reader.h"

#include "absl/strings/escaping.h"

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

}  // namespace

std::string Quoted(absl::string_view name) {
  constexpr size_t kLongest = 80;
  std::string text = absl::CHexEscape(name.substr(0, kLongest));
  return absl::StrCat("\"", text, name.size() > kLongest ? "...\"" : "\"");
}

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
    metadata[metadata_key_] = std::move(value);
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
    metadata_key_ = std::move(name);
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

}  // namespace sinew::internal
