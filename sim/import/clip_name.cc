#include "sim/import/clip_name.h"

#include <array>
#include <map>
#include <optional>
#include <regex>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "sim/import/detect_format.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

std::string ToUtf8(absl::string_view text) {
  std::string result;
  while (!text.empty()) {
    const size_t length = CharacterBytes(text);
    if (length == 0) {
      absl::StrAppendFormat(&result, "%%%02X", static_cast<uint8_t>(text[0]));
      text.remove_prefix(1);
      continue;
    }
    absl::StrAppend(&result, text.substr(0, length));
    text.remove_prefix(length);
  }
  return result;
}

// Name of the folder that a file lies in; empty for a bare name.
std::string FolderName(absl::string_view path) {
  const std::vector<absl::string_view> parts =
      absl::StrSplit(path, '/', absl::SkipEmpty());
  return parts.size() < 2 ? "" : ToUtf8(parts[parts.size() - 2]);
}

// "cmu/SS_TT" if the path is of a CMU trial.
std::optional<std::string> CmuTrial(absl::string_view path,
                                    const std::string& name) {
  static const std::regex kTrial("(^|[^0-9])([0-9]{1,3})_([0-9]{2})($|[^0-9])");
  std::smatch match;
  if (!std::regex_search(name, match, kTrial)) return std::nullopt;
  int subject = 0, trial = 0;
  if (!absl::SimpleAtoi(match[2].str(), &subject) ||
      !absl::SimpleAtoi(match[3].str(), &trial)) {
    return std::nullopt;
  }
  const bool nothing_else = match.length(0) == static_cast<int>(name.size());
  int folder = 0;
  const bool in_subject =
      absl::SimpleAtoi(FolderName(path), &folder) && folder == subject;
  if (!nothing_else && !in_subject &&
      !absl::StrContains(absl::AsciiStrToLower(path), "cmu")) {
    return std::nullopt;
  }
  return absl::StrFormat("cmu/%02d_%02d", subject, trial);
}

// The name without the testbed that a recording was played on, as ASAP puts it
// before the name of the video: "TairanTestbed_CR7_video_CR7" is "video_CR7".
// `name`: in lower case.
absl::string_view WithoutTestbed(absl::string_view name) {
  constexpr absl::string_view kVideo = "_video_";
  const size_t end = name.find(kVideo);
  if (end == absl::string_view::npos ||
      !absl::StrContains(name.substr(0, end), "testbed")) {
    return name;
  }
  return name.substr(end + 1);
}

// The names that a file may have, best first.
std::vector<std::string> Candidates(const NamedFile& file) {
  const std::string& path = file.path;
  const std::string name = file.name.empty() ? ClipName(path) : file.name;
  const std::string folder = FolderName(path);
  const std::string extension =
      std::string(absl::StripPrefix(LowerCaseExtension(path), "."));
  std::vector<std::string> names = {name};
  if (!folder.empty()) names.push_back(absl::StrCat(folder, "_", name));
  if (!extension.empty()) {
    names.push_back(absl::StrCat(name, "_", extension));
    if (!folder.empty()) {
      names.push_back(absl::StrCat(folder, "_", name, "_", extension));
    }
  }
  return names;
}

}  // namespace

std::string ClipName(absl::string_view path) {
  const absl::string_view base = path.substr(path.find_last_of('/') + 1);
  const size_t dot = base.find_last_of('.');
  return ToUtf8(
      dot == absl::string_view::npos || dot == 0 ? base : base.substr(0, dot));
}

std::string TrialName(absl::string_view path) {
  const std::string name = ClipName(path);
  if (const auto cmu = CmuTrial(path, name)) return *cmu;
  std::string trial(WithoutTestbed(absl::AsciiStrToLower(name)));
  constexpr std::array<absl::string_view, 5> kSuffixes = {
      "_mirror", "_mirrored", "_poses", "_stageii", "_retargeted"};
  for (bool changed = true; changed;) {
    changed = false;
    for (const absl::string_view suffix : kSuffixes) {
      if (trial.size() <= suffix.size() || !absl::EndsWith(trial, suffix)) {
        continue;
      }
      trial.resize(trial.size() - suffix.size());
      changed = true;
    }
  }
  return trial;
}

std::vector<absl::StatusOr<std::string>> UniqueNames(
    const std::vector<NamedFile>& files) {
  std::vector<absl::StatusOr<std::string>> names;
  std::map<std::string, const NamedFile*> taken;
  for (const NamedFile& file : files) {
    const std::vector<std::string> candidates = Candidates(file);
    absl::StatusOr<std::string> chosen;
    for (const std::string& candidate : candidates) {
      const auto [owner, free] = taken.try_emplace(candidate, &file);
      if (free) {
        chosen = candidate;
        break;
      }
      chosen = absl::AlreadyExistsError(
          absl::StrCat(file.path, ": expected a unique name, found \"",
                       candidate, "\" twice (also ", owner->second->path, ")"));
      const NamedFile& other = *owner->second;
      if ((file.name.empty() && other.path == file.path) ||
          (!file.sha256.empty() && other.sha256 == file.sha256)) {
        break;
      }
    }
    names.push_back(std::move(chosen));
  }
  return names;
}

}  // namespace sinew::import
