#include "common/config/text_proto.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "google/protobuf/text_format.h"

namespace sinew {
namespace {

// Keeps the first error; later ones follow from it.
class FirstError final : public google::protobuf::io::ErrorCollector {
 public:
  explicit FirstError(absl::string_view source) : source_(source) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column,
                const std::string& message) override {
    if (!text_.empty()) return;
    // Lines and columns count from 0; -1 means the whole input.
    text_ = line < 0 ? absl::StrCat(source_, ": ", message)
                     : absl::StrCat(source_, ":", line + 1, ":", column + 1,
                                    ": ", message);
  }

  const std::string& text() const { return text_; }

 private:
  const absl::string_view source_;
  std::string text_;
};

}  // namespace

absl::Status ParseTextProto(absl::string_view text, absl::string_view source,
                            google::protobuf::Message& message) {
  FirstError error(source);
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  google::protobuf::io::ArrayInputStream stream(text.data(),
                                                static_cast<int>(text.size()));
  if (parser.Parse(&stream, &message)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      error.text().empty() ? absl::StrCat(source, ": not a text proto")
                           : error.text());
}

}  // namespace sinew
