#ifndef SINEW_COMMON_POLICY_SAFETENSORS_READER_H_
#define SINEW_COMMON_POLICY_SAFETENSORS_READER_H_

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors_header.h"
#include "nlohmann/json.hpp"

namespace sinew::internal {

// A name from outside, fit for a message.
std::string Quoted(absl::string_view name);

// Takes the JSON apart as it is read, so that no document tree is built and
// only what a header may contain is accepted.
class HeaderReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  std::vector<SafetensorsEntry> entries;
  std::map<std::string, std::string> metadata;
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
  std::string metadata_key_;
  std::optional<std::vector<int64_t>> shape_;
  std::optional<std::vector<int64_t>> offsets_;
  std::set<std::string> names_;
};

}  // namespace sinew::internal

#endif  // SINEW_COMMON_POLICY_SAFETENSORS_READER_H_
