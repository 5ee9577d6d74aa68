#include "sim/import/formats/asf_text.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;

constexpr size_t kMaxBones = 2000;

std::span<double, 3> Numbers(Vector3d& vector) {
  return std::span<double, 3>(vector.data(), 3);
}

class Parser {
 public:
  Parser(absl::string_view bytes, absl::string_view source)
      : lines_(bytes), source_(source) {
    text_.bones.emplace_back();
    text_.bones[0].name = "root";
    text_.bones[0].length = 0;
  }

  absl::StatusOr<AsfText> Parse() {
    while (lines_.Next()) {
      if (lines_.text().empty() || lines_.text()[0] == '#') continue;
      SINEW_RETURN_IF_ERROR(ReadLine());
    }
    if (in_bone_) return Error("\"end\" of the last bone", "");
    if (text_.bones.size() < 2) return Error("a section :bonedata", "");
    text_.num_lines = lines_.number();
    return std::move(text_);
  }

 private:
  absl::Status Error(absl::string_view expected, absl::string_view found) {
    return LineError(source_, lines_.number(),
                     absl::StrCat("expected ", expected, ", found ",
                                  found.empty() ? "none" : Quoted(found)));
  }

  absl::Status ReadLine() {
    absl::string_view rest = lines_.text();
    const std::string word = absl::AsciiStrToLower(TakeWord(&rest));
    if (word[0] == ':') {
      if (in_bone_) return Error("\"end\" of a bone", word);
      section_ = word;
      return absl::OkStatus();
    }
    if (section_ == ":units") return ReadUnit(word, rest);
    if (section_ == ":root") return ReadRoot(word, rest);
    if (section_ == ":bonedata") return ReadBone(word, rest);
    if (section_ == ":hierarchy") return ReadLinks(rest);
    if (section_.empty()) return Error("a section of an ASF file", word);
    return absl::OkStatus();
  }

  absl::StatusOr<double> Number(absl::string_view* rest) {
    const absl::StatusOr<double> value = ParseNumber(TakeWord(rest));
    if (value.ok()) return value;
    return LineError(source_, lines_.number(), value.status().message());
  }

  // Takes three numbers off the front of `rest`.
  absl::Status ReadVector(absl::string_view* rest,
                          std::span<double, 3> vector) {
    for (double& value : vector) {
      SINEW_ASSIGN_OR_RETURN(value, Number(rest));
    }
    return absl::OkStatus();
  }

  // Three letters, each of x, y and z once.
  absl::Status ReadOrder(absl::string_view word, AsfAngles& angles) {
    bool seen[3] = {false, false, false};
    for (size_t i = 0; i < 3 && word.size() == 3; ++i) {
      const size_t axis =
          absl::string_view("xyz").find(absl::ascii_tolower(word[i]));
      if (axis == absl::string_view::npos || seen[axis]) break;
      seen[axis] = true;
      angles.axis[i] = static_cast<int>(axis);
    }
    if (seen[0] && seen[1] && seen[2]) return absl::OkStatus();
    return Error("an order of axes like XYZ", word);
  }

  absl::Status ReadChannels(absl::string_view rest, bool is_root,
                            std::vector<AsfChannel>& channels) {
    channels.clear();
    for (absl::string_view word = TakeWord(&rest); !word.empty();
         word = TakeWord(&rest)) {
      const char kind = absl::ascii_tolower(word[0]);
      const size_t axis =
          word.size() == 2
              ? absl::string_view("xyz").find(absl::ascii_tolower(word[1]))
              : absl::string_view::npos;
      const AsfChannel channel = {kind == 't', static_cast<int>(axis)};
      const bool is_new = std::none_of(
          channels.begin(), channels.end(), [&channel](const AsfChannel& c) {
            return c.is_position == channel.is_position &&
                   c.axis == channel.axis;
          });
      if (axis == absl::string_view::npos || !is_new ||
          !(kind == 'r' || (kind == 't' && is_root))) {
        return Error(is_root ? "each of TX TY TZ RX RY RZ at most once"
                             : "each of rx ry rz at most once",
                     word);
      }
      channels.push_back(channel);
    }
    return absl::OkStatus();
  }

  absl::Status ReadUnit(const std::string& key, absl::string_view rest) {
    if (key == "length") {
      SINEW_ASSIGN_OR_RETURN(const double length, Number(&rest));
      if (!(length >= 1e-6)) return Error("a length > 0", lines_.text());
      text_.length = length;
    } else if (key == "angle") {
      const absl::string_view unit = TakeWord(&rest);
      text_.angles_in_degrees = absl::StartsWithIgnoreCase(unit, "deg");
      if (!text_.angles_in_degrees &&
          !absl::StartsWithIgnoreCase(unit, "rad")) {
        return Error("an angle in deg or rad", unit);
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadRoot(const std::string& key, absl::string_view rest) {
    AsfTextBone& root = text_.bones[0];
    if (key == "order") return ReadChannels(rest, true, root.channels);
    if (key == "axis") return ReadOrder(TakeWord(&rest), root.axis);
    if (key == "position") {
      return ReadVector(&rest, Numbers(text_.root_position));
    }
    if (key == "orientation") return ReadVector(&rest, root.axis.value);
    return absl::OkStatus();
  }

  absl::Status ReadBone(const std::string& key, absl::string_view rest) {
    if (!in_bone_) {
      if (key != "begin") return Error("\"begin\" of a bone", key);
      if (text_.bones.size() > kMaxBones) {
        return Error(absl::StrCat("at most ", kMaxBones, " bones"), "more");
      }
      in_bone_ = true;
      text_.bones.emplace_back();
      return absl::OkStatus();
    }
    AsfTextBone& bone = text_.bones.back();
    if (key == "end") return EndBone();
    if (key == "name") {
      if (!bone.name.empty()) return Error("one name a bone", rest);
      absl::StatusOr<std::string> name = ParseName(rest);
      if (!name.ok()) {
        return LineError(source_, lines_.number(), name.status().message());
      }
      bone.name = *std::move(name);
    } else if (key == "direction") {
      return ReadVector(&rest, Numbers(bone.direction));
    } else if (key == "length") {
      SINEW_ASSIGN_OR_RETURN(bone.length, Number(&rest));
      if (bone.length < 0) return Error("a length >= 0", lines_.text());
    } else if (key == "axis") {
      SINEW_RETURN_IF_ERROR(ReadVector(&rest, bone.axis.value));
      const absl::string_view order = TakeWord(&rest);
      return order.empty() ? absl::OkStatus() : ReadOrder(order, bone.axis);
    } else if (key == "dof") {
      return ReadChannels(rest, false, bone.channels);
    }
    return absl::OkStatus();
  }

  absl::Status EndBone() {
    const AsfTextBone& bone = text_.bones.back();
    in_bone_ = false;
    if (bone.name.empty()) return Error("a bone with a name", "");
    if (bone.length < 0) {
      return Error(absl::StrCat("a length of bone ", Quoted(bone.name)), "");
    }
    return absl::OkStatus();
  }

  absl::Status ReadLinks(absl::string_view rest) {
    absl::string_view line = lines_.text();
    const absl::string_view parent = TakeWord(&line);
    for (absl::string_view child = TakeWord(&rest); !child.empty();
         child = TakeWord(&rest)) {
      text_.links.push_back(
          {lines_.number(), std::string(parent), std::string(child)});
    }
    return absl::OkStatus();
  }

  TextLines lines_;
  const absl::string_view source_;
  std::string section_;
  bool in_bone_ = false;
  AsfText text_;
};

}  // namespace

absl::StatusOr<AsfText> ReadAsfText(absl::string_view bytes,
                                    absl::string_view source) {
  return Parser(bytes, source).Parse();
}

}  // namespace sinew::import
