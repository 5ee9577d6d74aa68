#include "sim/import/formats/deepmimic_json.h"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Json = nlohmann::json;

// Receives the parser's events; returning false ends the parse.
class Reader : public Json::json_sax_t {
 public:
  bool null() override { return Value("null"); }
  bool boolean(bool) override { return Value("a boolean"); }
  bool number_integer(number_integer_t value) override {
    return Number(static_cast<double>(value));
  }
  bool number_unsigned(number_unsigned_t value) override {
    return Number(static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t&) override {
    return Number(value);
  }
  bool binary(binary_t&) override { return Value("binary"); }

  bool string(string_t& text) override {
    if (depth_ != 1 || key_ != "Loop") return Value("a string");
    if (text != "wrap" && text != "none") {
      return Fail(absl::StrCat(
          "\"Loop\": expected \"wrap\" or \"none\", found ", Quoted(text)));
    }
    file_.loops = text == "wrap";
    return true;
  }

  bool key(string_t& text) override {
    if (depth_ == 1) key_ = text;
    return true;
  }
  bool start_object(size_t) override {
    if (depth_ > 0 && !Value("an object")) return false;
    ++depth_;
    return true;
  }
  bool end_object() override {
    --depth_;
    return true;
  }

  bool start_array(size_t) override {
    if (depth_ == 0) return Value("an array");
    if (depth_ == 1 && key_ == "Frames") {
      if (has_frames_) return Fail("\"Frames\": found twice");
      has_frames_ = true;
      in_frames_ = true;
    } else if (in_frames_ && depth_ == 2) {
      file_.frames.emplace_back();
    } else if (!Value("an array")) {
      return false;
    }
    ++depth_;
    return true;
  }
  bool end_array() override {
    --depth_;
    if (depth_ == 1) in_frames_ = false;
    return true;
  }

  // `read`: what was read since the last number or string.
  bool parse_error(size_t position, const std::string& read,
                   const Json::exception& error) override {
    const std::string token = read.substr(read.find_last_of(" ,[\n\t") + 1);
    if (token == "N" || token == "I" || token == "-I" || error.id == 406) {
      return Fail(absl::StrCat("expected finite numbers, found \"", token,
                               "\" at byte ", position,
                               in_frames_ ? InFrame() : ""));
    }
    constexpr size_t kMostMessage = 300;  // a message quotes whole tokens
    return Fail(absl::StrCat(
        "expected JSON: ",
        absl::CHexEscape(
            absl::string_view(error.what()).substr(0, kMostMessage))));
  }

  bool complete() const { return has_frames_; }
  const std::string& error() const { return error_; }
  DeepMimicFile TakeFile() { return std::move(file_); }

 private:
  bool Fail(std::string what) {
    error_ = std::move(what);
    return false;
  }

  std::string InFrame() const {
    return absl::StrCat(" in frame ",
                        file_.frames.empty() ? 0 : file_.frames.size() - 1);
  }

  bool Number(double value) {
    if (!in_frames_ || depth_ != 3) return Value("a number");
    file_.frames.back().push_back(value);
    return true;
  }

  // Any value that is not a number inside a frame: an error only where the
  // format asks for something else.
  bool Value(const char* found) {
    if (depth_ == 0) {
      return Fail(absl::StrCat("expected an object, found ", found));
    }
    if (in_frames_) {
      return Fail(absl::StrCat("\"Frames\": expected ",
                               depth_ == 2 ? "an array of numbers" : "a number",
                               ", found ", found,
                               depth_ == 2 ? "" : InFrame()));
    }
    if (depth_ == 1 && (key_ == "Frames" || key_ == "Loop")) {
      return Fail(absl::StrCat("\"", key_, "\": expected ",
                               key_ == "Frames" ? "an array" : "a string",
                               ", found ", found));
    }
    return true;
  }

  int depth_ = 0;  // open brackets
  std::string key_;
  bool has_frames_ = false;
  bool in_frames_ = false;
  std::string error_;
  DeepMimicFile file_;
};

}  // namespace

absl::StatusOr<DeepMimicFile> ReadDeepMimicJson(absl::string_view json,
                                                absl::string_view source) {
  Reader reader;
  if (!Json::sax_parse(json.begin(), json.end(), &reader)) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": ", reader.error()));
  }
  if (!reader.complete()) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected a key \"Frames\", found none"));
  }
  return reader.TakeFile();
}

}  // namespace sinew::import
