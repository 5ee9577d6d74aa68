#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/config/recipe.h"
#include "common/config/text_proto.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"

namespace sinew {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::string FieldNames(const Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) {
    names.push_back(type.field(i)->name());
  }
  return absl::StrJoin(names, ", ");
}

// Enum values may be written without their prefix: the common part up to the
// last underscore that all names share is tried in front.
std::string EnumValue(const FieldDescriptor& field, const std::string& value) {
  const auto& type = *field.enum_type();
  if (type.FindValueByName(value) != nullptr) return value;
  for (int i = 0; i < type.value_count(); ++i) {
    if (absl::EndsWith(type.value(i)->name(),
                       absl::StrCat("_", absl::AsciiStrToUpper(value)))) {
      return type.value(i)->name();
    }
  }
  return value;
}

// The value in text format: strings quoted, enums by full name.
std::string TextValue(const FieldDescriptor& field, absl::string_view value) {
  std::string text(absl::StripAsciiWhitespace(value));
  if (field.type() == FieldDescriptor::TYPE_ENUM && !absl::StartsWith(text, "[")) {
    return EnumValue(field, text);
  }
  if (field.type() == FieldDescriptor::TYPE_STRING &&
      !absl::StartsWith(text, "\"")) {
    return absl::StrCat(
        "\"", absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"\"", "\\\""}}), "\"");
  }
  return text;
}

}  // namespace

absl::Status SetRecipeField(v1::Recipe& recipe, absl::string_view assignment) {
  const std::vector<std::string> halves =
      absl::StrSplit(assignment, absl::MaxSplits('=', 1));
  if (halves.size() != 2 || halves[0].empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--set: expected path=value, found \"", assignment, "\""));
  }
  const std::vector<std::string> path = absl::StrSplit(halves[0], '.');
  // Build the text form "a { b { c: value } }" and let the parser check it,
  // then replace the field in the recipe.
  Message* message = &recipe;
  const FieldDescriptor* field = nullptr;
  for (size_t i = 0; i < path.size(); ++i) {
    field = message->GetDescriptor()->FindFieldByName(path[i]);
    if (field == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--set ", halves[0], ": no recipe field \"", path[i],
          "\", expected one of: ", FieldNames(*message->GetDescriptor())));
    }
    const bool is_message =
        field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    const bool last = i + 1 == path.size();
    if (last == is_message) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--set ", halves[0], ": expected ",
          last ? "a field inside the group" : "a group before the dot",
          ", found ", path[i],
          last ? absl::StrCat(" (one of: ",
                              FieldNames(*field->message_type()), ")")
               : ""));
    }
    if (!last) {
      message = message->GetReflection()->MutableMessage(message, field);
    }
  }
  std::unique_ptr<Message> parsed(message->New());
  absl::Status status =
      ParseTextProto(absl::StrCat(field->name(), ": ",
                                  TextValue(*field, halves[1])),
                     absl::StrCat("--set ", halves[0]), *parsed);
  if (!status.ok()) return status;
  message->GetReflection()->ClearField(message, field);
  message->MergeFrom(*parsed);
  return absl::OkStatus();
}

}  // namespace sinew
