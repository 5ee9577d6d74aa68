#include "sim/import/formats/robot_layout.h"

#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/config/text_proto.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/workspace_files.h"
#include "sim/import/formats/file_frame.h"

namespace sinew::import {
namespace {

constexpr int64_t kMaxBytes = 1 << 20;
constexpr int kMaxJoints = 500;
constexpr const char* kKnown[] = {"g1_23dof", "g1_29dof", "h1_2"};

bool IsShortName(absl::string_view name) {
  return !name.empty() &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") ==
             absl::string_view::npos;
}

absl::Status CheckLayout(const v1::RobotLayout& layout,
                         absl::string_view source) {
  const auto error = [source](absl::string_view field,
                              absl::string_view expected,
                              absl::string_view found) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": ", field, ": expected ", expected, ", found ", found));
  };
  if (!IsShortName(layout.name())) {
    return error("name", "[a-z0-9_]+", absl::StrCat("\"", layout.name(), "\""));
  }
  if (layout.joints().empty() || layout.joints_size() > kMaxJoints) {
    return error("joints", absl::StrCat("1 to ", kMaxJoints),
                 absl::StrCat(layout.joints_size()));
  }
  std::set<std::string> seen;
  for (const std::string& joint : layout.joints()) {
    if (joint.empty() || !seen.insert(joint).second) {
      return error("joints", "names, each once",
                   joint.empty() ? "an empty one"
                                 : absl::StrCat("\"", joint, "\" twice"));
    }
  }
  const double rate = layout.frames_per_second();
  if (!(rate >= 0 && rate <= kMaxFramesPerSecond)) {
    return error("frames_per_second",
                 absl::StrCat("0 to ", kMaxFramesPerSecond),
                 absl::StrCat(rate));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::RobotLayout> ParseRobotLayout(absl::string_view text,
                                                 absl::string_view source) {
  v1::RobotLayout layout;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, source, layout));
  SINEW_RETURN_IF_ERROR(CheckLayout(layout, source));
  return layout;
}

absl::StatusOr<std::vector<v1::RobotLayout>> KnownRobotLayouts() {
  std::vector<v1::RobotLayout> layouts;
  for (const char* name : kKnown) {
    SINEW_ASSIGN_OR_RETURN(const std::string path,
                           FindWorkspaceFile(absl::StrCat("sim/import/maps/",
                                                          name, ".textproto")));
    SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxBytes));
    SINEW_ASSIGN_OR_RETURN(v1::RobotLayout layout,
                           ParseRobotLayout(text, path));
    layouts.push_back(std::move(layout));
  }
  return layouts;
}

}  // namespace sinew::import
