#include "common/config/text_proto.h"

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/config/nearest_name.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "google/protobuf/message.h"
#include "google/protobuf/text_format.h"

namespace sinew {
namespace {

constexpr size_t kMaxBytes = size_t{64} << 20;
constexpr int kMaxDepth = 64;
// Of the offending line, so much is shown.
constexpr size_t kMaxShown = 80;

// Line `index` (from 0) without its margins.
std::string LineOf(absl::string_view text, int index) {
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    if (index-- > 0) continue;
    return absl::CHexEscape(
        absl::StripAsciiWhitespace(line).substr(0, kMaxShown));
  }
  return "";
}

// What lies between `before` and the next quotation mark; empty if nothing.
absl::string_view QuotedAfter(absl::string_view message,
                              absl::string_view before) {
  const size_t at = message.find(before);
  if (at == absl::string_view::npos) return "";
  const absl::string_view rest = message.substr(at + before.size());
  return rest.substr(0, rest.find('"'));
}

// " The nearest is ..." if the parser did not know a field.
std::string Hint(absl::string_view message,
                 const google::protobuf::Descriptor& root) {
  const google::protobuf::Descriptor* type =
      root.file()->pool()->FindMessageTypeByName(
          std::string(QuotedAfter(message, "Message type \"")));
  const absl::string_view typed = QuotedAfter(message, "no field named \"");
  if (type == nullptr || typed.empty()) return "";
  std::vector<std::string> names;
  for (int i = 0; i < type->field_count(); ++i) {
    names.push_back(type->field(i)->name());
  }
  return absl::StrCat(" The nearest is \"", NearestName(typed, names), "\"");
}

// Keeps the first error; later ones follow from it.
class FirstError final : public google::protobuf::io::ErrorCollector {
 public:
  FirstError(absl::string_view text, absl::string_view source,
             const google::protobuf::Descriptor& type)
      : text_(text), source_(source), type_(type) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column,
                const std::string& message) override {
    if (!error_.empty()) return;
    error_ = std::string(source_);
    // Lines and columns count from 0; -1 means the whole input.
    if (line >= 0) absl::StrAppend(&error_, ":", line + 1, ":", column + 1);
    absl::StrAppend(&error_, ": ", message, Hint(message, type_));
    if (line < 0) return;
    const std::string shown = LineOf(text_, line);
    if (!shown.empty()) absl::StrAppend(&error_, " in: ", shown);
  }

  const std::string& error() const { return error_; }

 private:
  const absl::string_view text_;
  const absl::string_view source_;
  const google::protobuf::Descriptor& type_;
  std::string error_;
};

}  // namespace

absl::Status ParseTextProto(absl::string_view text, absl::string_view source,
                            google::protobuf::Message& message) {
  if (text.size() >= kMaxBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected less than ", kMaxBytes,
                     " bytes of text, found ", text.size()));
  }
  FirstError error(text, source, *message.GetDescriptor());
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  parser.SetRecursionLimit(kMaxDepth);
  google::protobuf::io::ArrayInputStream stream(text.data(),
                                                static_cast<int>(text.size()));
  if (parser.Parse(&stream, &message)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      error.error().empty() ? absl::StrCat(source, ": not a text proto")
                            : error.error());
}

}  // namespace sinew
