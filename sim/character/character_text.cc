#include "sim/character/character_text.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::character {
namespace {

constexpr int kFormatVersion = 1;

class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, int column, const std::string& message) override {
    if (!text_.empty()) return;
    // Counted from 0 by the parser, from 1 by people.
    text_ =
        absl::StrCat("line ", line + 1, ", column ", column + 1, ": ", message);
  }
  void AddWarning(int, int, const std::string&) override {}

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

absl::Status Bad(absl::string_view source, absl::string_view field,
                 absl::string_view expected, const absl::AlphaNum& found) {
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": ", field, ": expected ", expected, ", found ", found));
}

bool IsName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

absl::Status CheckJoint(absl::string_view source, const v1::Joint& joint) {
  const std::string field = absl::StrCat("joint \"", joint.name(), "\": ");
  struct Rule {
    const char* name;
    double value;
    double least;
    bool inclusive;
  };
  const std::array<Rule, 5> rules = {{
      {"stiffness", joint.stiffness(), 0, false},
      {"damping", joint.damping(), 0, true},
      {"torque_limit", joint.torque_limit(), 0, false},
      {"action_scale", joint.action_scale(), 0, true},
      {"armature", joint.armature(), 0, true},
  }};
  for (const Rule& rule : rules) {
    const bool in_range =
        rule.inclusive ? rule.value >= rule.least : rule.value > rule.least;
    if (!std::isfinite(rule.value) || !in_range) {
      return Bad(source, field + rule.name,
                 rule.inclusive ? "a number >= 0" : "a number > 0", rule.value);
    }
  }
  if (!std::isfinite(joint.default_position())) {
    return Bad(source, field + "default_position", "a finite number",
               joint.default_position());
  }
  return absl::OkStatus();
}

absl::Status CheckJoints(absl::string_view source,
                         const v1::Character& character) {
  if (character.joints().empty()) {
    return Bad(source, "joints", "at least one", 0);
  }
  std::set<std::string> names;
  for (const v1::Joint& joint : character.joints()) {
    if (joint.name().empty()) {
      return Bad(source, "joints.name", "a name", "\"\"");
    }
    if (!names.insert(joint.name()).second) {
      return Bad(source, "joints", "each joint once",
                 absl::StrCat("\"", joint.name(), "\" again"));
    }
    SINEW_RETURN_IF_ERROR(CheckJoint(source, joint));
  }
  return absl::OkStatus();
}

absl::Status Check(absl::string_view source, const v1::Character& character) {
  if (character.format_version() != kFormatVersion) {
    return Bad(source, "format_version", absl::StrCat(kFormatVersion),
               character.format_version());
  }
  if (!IsName(character.name())) {
    return Bad(source, "name", "lower-case letters, digits and _",
               absl::StrCat("\"", character.name(), "\""));
  }
  if (character.model_file().empty()) {
    return Bad(source, "model_file", "a file", "\"\"");
  }
  SINEW_RETURN_IF_ERROR(CheckJoints(source, character));
  if (character.feet().empty()) {
    return Bad(source, "feet", "at least one", 0);
  }
  if (!std::isfinite(character.standing_root_height()) ||
      character.standing_root_height() <= 0) {
    return Bad(source, "standing_root_height", "a number > 0",
               character.standing_root_height());
  }
  if (character.actuator_law().derivation().empty()) {
    return Bad(source, "actuator_law.derivation", "how the gains were derived",
               "\"\"");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::Character> ParseCharacter(absl::string_view text,
                                             absl::string_view source) {
  google::protobuf::TextFormat::Parser parser;
  FirstError error;
  parser.RecordErrorsTo(&error);
  v1::Character character;
  if (!parser.ParseFromString(std::string(text), &character)) {
    return absl::InvalidArgumentError(absl::StrCat(source, ": ", error.text()));
  }
  SINEW_RETURN_IF_ERROR(Check(source, character));
  return character;
}

std::string PrintCharacter(const v1::Character& character) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(character, &text);
  return text;
}

}  // namespace sinew::character
