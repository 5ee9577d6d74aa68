#include "sim/import/formats/bvh_hierarchy.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/unique_names.h"

namespace sinew::import {
namespace {

constexpr size_t kMaxJoints = 2000;
constexpr size_t kMaxDepth = 256;
constexpr int kMaxChannels = 6;

// Words and braces of a text, across lines.
class Words {
 public:
  explicit Words(TextLines& lines) : lines_(lines) {}

  // The next word or brace; empty at the end.
  absl::string_view Next() {
    rest_ = absl::StripLeadingAsciiWhitespace(rest_);
    while (rest_.empty()) {
      if (!lines_.Next()) return {};
      rest_ = lines_.text();
    }
    size_t end = 0;
    while (end < rest_.size() && !absl::ascii_isspace(rest_[end]) &&
           !IsBrace(rest_[end])) {
      ++end;
    }
    return Take(std::max<size_t>(end, 1));
  }

  // The rest of the line, up to a brace.
  absl::string_view RestOfLine() {
    return absl::StripAsciiWhitespace(
        Take(std::min(rest_.find_first_of("{}"), rest_.size())));
  }

 private:
  static bool IsBrace(char c) { return c == '{' || c == '}'; }

  absl::string_view Take(size_t bytes) {
    const absl::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }

  TextLines& lines_;
  absl::string_view rest_;
};

bool Is(absl::string_view word, absl::string_view keyword) {
  return absl::EqualsIgnoreCase(word, keyword);
}

class Parser {
 public:
  Parser(TextLines& lines, absl::string_view source)
      : lines_(lines), words_(lines), source_(source) {}

  absl::StatusOr<BvhHierarchy> Parse() {
    SINEW_RETURN_IF_ERROR(Expect("HIERARCHY"));
    SINEW_RETURN_IF_ERROR(Expect("ROOT"));
    SINEW_RETURN_IF_ERROR(OpenJoint());
    while (!open_.empty()) SINEW_RETURN_IF_ERROR(ReadItem());
    SINEW_RETURN_IF_ERROR(Expect("MOTION"));
    const absl::string_view rest = words_.RestOfLine();
    if (!rest.empty()) return Error("a line of its own for MOTION", rest);
    if (hierarchy_.num_channels == 0) {
      return LineError(source_, lines_.number(),
                       "expected at least one channel, found none");
    }
    NameJoints();
    return std::move(hierarchy_);
  }

 private:
  absl::Status Error(absl::string_view expected, absl::string_view found) {
    return LineError(
        source_, lines_.number(),
        absl::StrCat("expected ", expected, ", found ",
                     found.empty() ? "the end of the file" : Quoted(found)));
  }

  absl::Status Expect(absl::string_view keyword) {
    const absl::string_view word = words_.Next();
    return Is(word, keyword) ? absl::OkStatus() : Error(keyword, word);
  }

  absl::StatusOr<double> Number() {
    const absl::string_view word = words_.Next();
    const absl::StatusOr<double> value = ParseNumber(word);
    if (value.ok()) return value;
    return word.empty()
               ? Error("a number", word)
               : LineError(source_, lines_.number(), value.status().message());
  }

  BvhJoint& current() { return hierarchy_.joints[open_.back()]; }

  // One thing inside the joint that is open.
  absl::Status ReadItem() {
    const absl::string_view word = words_.Next();
    if (Is(word, "OFFSET")) return ReadOffset();
    if (Is(word, "CHANNELS")) return ReadChannels();
    if (Is(word, "JOINT") && !current().is_end) return OpenJoint();
    if (Is(word, "End") && !current().is_end) return OpenEnd();
    if (word == "}") return CloseJoint();
    return Error(current().is_end
                     ? "OFFSET or } in an End Site"
                     : absl::StrCat("OFFSET, CHANNELS, JOINT, End Site or } in "
                                    "joint ",
                                    Quoted(current().name)),
                 word);
  }

  absl::Status OpenJoint() {
    absl::StatusOr<std::string> name = ParseName(words_.RestOfLine());
    if (!name.ok()) {
      return LineError(source_, lines_.number(), name.status().message());
    }
    return Open(*std::move(name), /*is_end=*/false);
  }

  absl::Status OpenEnd() {
    SINEW_RETURN_IF_ERROR(Expect("Site"));
    words_.RestOfLine();  // some writers name it
    return Open(absl::StrCat(current().name, "_end"), /*is_end=*/true);
  }

  absl::Status Open(std::string name, bool is_end) {
    SINEW_RETURN_IF_ERROR(Expect("{"));
    if (hierarchy_.joints.size() == kMaxJoints || open_.size() == kMaxDepth) {
      return LineError(source_, lines_.number(),
                       absl::StrCat("expected at most ", kMaxJoints,
                                    " joints, nested at most ", kMaxDepth,
                                    " deep, found more"));
    }
    BvhJoint joint;
    joint.name = std::move(name);
    joint.parent = open_.empty() ? -1 : open_.back();
    joint.is_end = is_end;
    open_.push_back(static_cast<int>(hierarchy_.joints.size()));
    hierarchy_.joints.push_back(std::move(joint));
    return absl::OkStatus();
  }

  absl::Status CloseJoint() {
    if (!current().has_offset) {
      return Error(absl::StrCat("an OFFSET in joint ", Quoted(current().name)),
                   "}");
    }
    open_.pop_back();
    return absl::OkStatus();
  }

  absl::Status ReadOffset() {
    if (current().has_offset) return Error("one OFFSET a joint", "OFFSET");
    current().has_offset = true;
    for (int axis = 0; axis < 3; ++axis) {
      SINEW_ASSIGN_OR_RETURN(current().offset[axis], Number());
    }
    return absl::OkStatus();
  }

  absl::Status ReadChannels() {
    std::vector<BvhChannel>& channels = current().channels;
    if (!channels.empty()) return Error("CHANNELS once a joint", "CHANNELS");
    const absl::string_view word = words_.Next();
    int count = 0;
    if (!absl::SimpleAtoi(word, &count) || count < 0 || count > kMaxChannels ||
        (count > 0 && current().is_end)) {
      return Error(current().is_end ? "no channels in an End Site"
                                    : "a number of channels from 0 to 6",
                   word);
    }
    for (int i = 0; i < count; ++i) {
      SINEW_RETURN_IF_ERROR(ReadChannel(channels));
    }
    hierarchy_.num_channels += count;
    return absl::OkStatus();
  }

  absl::Status ReadChannel(std::vector<BvhChannel>& channels) {
    const absl::string_view word = words_.Next();
    BvhChannel channel;
    channel.is_position = absl::EndsWithIgnoreCase(word, "position");
    const size_t axis =
        word.size() == 9
            ? absl::string_view("xyz").find(absl::ascii_tolower(word[0]))
            : absl::string_view::npos;
    if (axis == absl::string_view::npos ||
        !(channel.is_position || absl::EndsWithIgnoreCase(word, "rotation"))) {
      return Error("a channel (Xposition to Zrotation)", word);
    }
    channel.axis = static_cast<int>(axis);
    int rotations = channel.is_position ? 0 : 1;
    for (const BvhChannel& other : channels) {
      if (!other.is_position) ++rotations;
      if (channel.is_position && other.is_position &&
          other.axis == channel.axis) {
        return Error("each position channel once a joint", word);
      }
    }
    if (rotations > 3) return Error("at most 3 rotation channels", word);
    channels.push_back(channel);
    return absl::OkStatus();
  }

  // Joints go before end sites, which are named after them.
  void NameJoints() {
    UniqueNames names;
    std::vector<std::string> twice;
    for (BvhJoint& joint : hierarchy_.joints) {
      if (joint.is_end) continue;
      std::string name = names.Take(joint.name);
      if (name != joint.name) twice.push_back(Quoted(joint.name));
      joint.name = std::move(name);
    }
    for (BvhJoint& joint : hierarchy_.joints) {
      if (!joint.is_end) continue;
      joint.name = names.Take(
          absl::StrCat(hierarchy_.joints[joint.parent].name, "_end"));
    }
    if (!twice.empty()) {
      hierarchy_.warnings.push_back(absl::StrCat(
          "joint names found twice got a number: ", twice[0],
          twice.size() > 1 ? absl::StrCat(" and ", twice.size() - 1, " more")
                           : ""));
    }
  }

  TextLines& lines_;
  Words words_;
  const absl::string_view source_;
  std::vector<int> open_;  // joints whose brace is open
  BvhHierarchy hierarchy_;
};

}  // namespace

bool BvhJoint::has_position() const {
  return std::any_of(
      channels.begin(), channels.end(),
      [](const BvhChannel& channel) { return channel.is_position; });
}

absl::StatusOr<BvhHierarchy> ReadBvhHierarchy(TextLines& lines,
                                              absl::string_view source) {
  return Parser(lines, source).Parse();
}

}  // namespace sinew::import
