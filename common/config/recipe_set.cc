#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/config/nearest_name.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"

namespace sinew {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// A field somewhere below the recipe.
struct Place {
  Message* message;
  const FieldDescriptor* field;
};

std::vector<std::string> FieldNames(const Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) {
    names.push_back(type.field(i)->name());
  }
  return names;
}

absl::Status Wrong(absl::string_view path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("--set ", path, ": ", what));
}

absl::Status ListOfGroups(absl::string_view path,
                          const FieldDescriptor& field) {
  return Wrong(path, absl::StrCat(field.name(),
                                  " is a list of groups; expected "
                                  "it in the recipe's file"));
}

absl::StatusOr<Place> FindPlace(Message& root, absl::string_view path) {
  Place place = {&root, nullptr};
  for (absl::string_view name : absl::StrSplit(path, '.')) {
    if (place.field != nullptr) {
      if (place.field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
        return Wrong(path, absl::StrCat(place.field->name(),
                                        " is a value and has no field ", name));
      }
      if (place.field->is_repeated()) return ListOfGroups(path, *place.field);
      place.message = place.message->GetReflection()->MutableMessage(
          place.message, place.field);
    }
    const Descriptor& type = *place.message->GetDescriptor();
    place.field = type.FindFieldByName(std::string(name));
    if (place.field == nullptr) {
      const std::vector<std::string> names = FieldNames(type);
      return Wrong(
          path, absl::StrCat("no recipe field \"", name,
                             "\"; the nearest is \"", NearestName(name, names),
                             "\" of ", absl::StrJoin(names, ", ")));
    }
  }
  if (place.field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    if (place.field->is_repeated()) return ListOfGroups(path, *place.field);
    return Wrong(
        path,
        absl::StrCat(
            "expected a field inside the group, one of ",
            absl::StrJoin(FieldNames(*place.field->message_type()), ", ")));
  }
  return place;
}

// A value by its name, or by its name without the enum's own ("bins" and
// "RULE_BINS" of Rule). Null if there is none.
const EnumValueDescriptor* FindEnumValue(const EnumDescriptor& type,
                                         absl::string_view text) {
  const std::string upper = absl::AsciiStrToUpper(text);
  const auto* value = type.FindValueByName(upper);
  if (value != nullptr) return value;
  return type.FindValueByName(
      absl::StrCat(absl::AsciiStrToUpper(type.name()), "_", upper));
}

std::vector<std::string> EnumNames(const EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() != 0) names.push_back(type.value(i)->name());
  }
  return names;
}

// Parses one value of the field's type, hands it to `put`; false if it is none.
template <typename Put>
bool ParseValue(const FieldDescriptor& field, const std::string& text,
                Put&& put) {
  const auto parse = [&](auto value, auto&& parser) {
    if (!parser(text, &value)) return false;
    put(value);
    return true;
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return parse(int32_t{}, absl::SimpleAtoi<int32_t>);
    case FieldDescriptor::CPPTYPE_INT64:
      return parse(int64_t{}, absl::SimpleAtoi<int64_t>);
    case FieldDescriptor::CPPTYPE_UINT64:
      return parse(uint64_t{}, absl::SimpleAtoi<uint64_t>);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return parse(double{}, absl::SimpleAtod);
    case FieldDescriptor::CPPTYPE_BOOL:
      return parse(bool{}, absl::SimpleAtob);
    case FieldDescriptor::CPPTYPE_STRING:
      put(text);
      return true;
    case FieldDescriptor::CPPTYPE_ENUM: {
      const auto* value = FindEnumValue(*field.enum_type(), text);
      if (value != nullptr) put(value);
      return value != nullptr;
    }
    default:
      return false;
  }
}

// Writes a parsed value into a field, or adds it to a repeated one.
class Setter {
 public:
  explicit Setter(const Place& place) : place_(place) {}

  void operator()(int32_t v) {
    Put(v, &Reflection::SetInt32, &Reflection::AddInt32);
  }
  void operator()(int64_t v) {
    Put(v, &Reflection::SetInt64, &Reflection::AddInt64);
  }
  void operator()(uint64_t v) {
    Put(v, &Reflection::SetUInt64, &Reflection::AddUInt64);
  }
  void operator()(double v) {
    Put(v, &Reflection::SetDouble, &Reflection::AddDouble);
  }
  void operator()(bool v) {
    Put(v, &Reflection::SetBool, &Reflection::AddBool);
  }
  void operator()(const std::string& v) {
    Put(v, &Reflection::SetString, &Reflection::AddString);
  }
  void operator()(const EnumValueDescriptor* v) {
    Put(v, &Reflection::SetEnum, &Reflection::AddEnum);
  }

 private:
  template <typename T, typename Set, typename Add>
  void Put(const T& value, Set set, Add add) {
    const Reflection& reflection = *place_.message->GetReflection();
    if (place_.field->is_repeated()) {
      (reflection.*add)(place_.message, place_.field, value);
    } else {
      (reflection.*set)(place_.message, place_.field, value);
    }
  }

  const Place place_;
};

std::string ExpectedOf(const FieldDescriptor& field) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
    return absl::StrCat("one of ",
                        absl::StrJoin(EnumNames(*field.enum_type()), ", "));
  }
  return absl::StrCat("a value of type ", field.type_name());
}

// The elements of "[a, b]", of a bare "a", or of a string in quotes.
std::vector<std::string> Elements(const FieldDescriptor& field,
                                  absl::string_view text) {
  if (!field.is_repeated()) {
    const bool quoted = text.size() >= 2 && absl::StartsWith(text, "\"") &&
                        absl::EndsWith(text, "\"");
    return {std::string(quoted ? text.substr(1, text.size() - 2) : text)};
  }
  if (absl::StartsWith(text, "[") && absl::EndsWith(text, "]")) {
    text = absl::StripAsciiWhitespace(text.substr(1, text.size() - 2));
    if (text.empty()) return {};
  }
  std::vector<std::string> elements;
  for (absl::string_view element : absl::StrSplit(text, ',')) {
    elements.emplace_back(absl::StripAsciiWhitespace(element));
  }
  return elements;
}

}  // namespace

absl::Status SetRecipeField(v1::Recipe& recipe, absl::string_view assignment) {
  const std::vector<absl::string_view> halves =
      absl::StrSplit(assignment, absl::MaxSplits('=', 1));
  const absl::string_view path = absl::StripAsciiWhitespace(halves[0]);
  if (halves.size() != 2 || path.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--set: expected path=value, found \"", assignment, "\""));
  }
  v1::Recipe changed = recipe;
  SINEW_ASSIGN_OR_RETURN(const Place place, FindPlace(changed, path));
  place.message->GetReflection()->ClearField(place.message, place.field);
  for (const std::string& element :
       Elements(*place.field, absl::StripAsciiWhitespace(halves[1]))) {
    if (!ParseValue(*place.field, element, Setter(place))) {
      return Wrong(path, absl::StrCat("expected ", ExpectedOf(*place.field),
                                      ", found \"", element, "\""));
    }
  }
  recipe = std::move(changed);
  return absl::OkStatus();
}

}  // namespace sinew
