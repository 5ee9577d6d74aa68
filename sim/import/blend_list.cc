#include "sim/import/blend_list.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/text_proto.h"
#include "common/files.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/blend_list.pb.h"
#include "sim/import/clip_name.h"
#include "sim/import/edit.h"

namespace sinew::import {
namespace {

constexpr int64_t kMaxBytes = int64_t{1} << 20;

BlendOptions OptionsOf(const v1::ListedBlend& listed) {
  BlendOptions options;
  if (listed.has_gap_s()) options.gap_s = listed.gap_s();
  options.first.from_s = listed.first_from_s();
  if (listed.has_first_to_s()) options.first.to_s = listed.first_to_s();
  options.second.from_s = listed.second_from_s();
  if (listed.has_second_to_s()) options.second.to_s = listed.second_to_s();
  return options;
}

std::string NameOf(const v1::ListedBlend& listed) {
  return listed.name().empty() ? BlendName(listed.first(), listed.second())
                               : listed.name();
}

absl::Status CheckPath(absl::string_view field, const std::string& path) {
  if (!path.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected a path, found none"));
}

// 0 <= from < to.
absl::Status CheckKept(absl::string_view clip, double from_s,
                       std::optional<double> to_s) {
  if (!(from_s >= 0) || !std::isfinite(from_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat(clip, "_from_s: expected >= 0, found ", from_s));
  }
  if (to_s && (!(*to_s > from_s) || !std::isfinite(*to_s))) {
    return absl::InvalidArgumentError(absl::StrCat(
        clip, "_to_s: expected more than ", from_s, ", found ", *to_s));
  }
  return absl::OkStatus();
}

absl::Status CheckName(const std::string& name) {
  const auto allowed = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' ||
           c == '-' || c == '.';
  };
  if (std::all_of(name.begin(), name.end(), allowed)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("name: expected letters, digits, _, - and ., found \"",
                   absl::CHexEscape(name), "\""));
}

absl::Status CheckListed(const v1::ListedBlend& listed) {
  const auto set = [](bool has, double value) {
    return has ? std::optional(value) : std::nullopt;
  };
  SINEW_RETURN_IF_ERROR(CheckPath("first", listed.first()));
  SINEW_RETURN_IF_ERROR(CheckPath("second", listed.second()));
  SINEW_RETURN_IF_ERROR(CheckName(listed.name()));
  SINEW_RETURN_IF_ERROR(
      WithContext(CheckBlendGap(OptionsOf(listed).gap_s), "gap_s"));
  SINEW_RETURN_IF_ERROR(
      CheckKept("first", listed.first_from_s(),
                set(listed.has_first_to_s(), listed.first_to_s())));
  return CheckKept("second", listed.second_from_s(),
                   set(listed.has_second_to_s(), listed.second_to_s()));
}

// Where relative paths begin.
absl::StatusOr<std::filesystem::path> RootOf(const std::string& list,
                                             const std::string& root) {
  if (root.empty()) return std::filesystem::path(list).parent_path();
  std::error_code error;
  if (std::filesystem::is_directory(root, error)) return root;
  return absl::InvalidArgumentError(
      absl::StrCat("root: expected a folder, found \"", root, "\""));
}

}  // namespace

absl::StatusOr<std::vector<BlendedFiles>> ReadBlendList(
    const std::string& path, const std::string& root) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxBytes));
  v1::BlendList list;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, path, list));
  if (list.blends().empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": blends: expected at least one, found none"));
  }
  SINEW_ASSIGN_OR_RETURN(const std::filesystem::path from, RootOf(path, root));
  std::vector<BlendedFiles> blends;
  std::map<std::string, size_t> pair_of;  // by name
  for (const v1::ListedBlend& listed : list.blends()) {
    const size_t pair = blends.size() + 1;
    const std::string context = absl::StrCat(path, ": pair ", pair);
    SINEW_RETURN_IF_ERROR(WithContext(CheckListed(listed), context));
    const auto [other, is_new] = pair_of.emplace(NameOf(listed), pair);
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat(
          context, ": name: expected one that no other pair has, found \"",
          other->first, "\" (pair ", other->second, ")"));
    }
    // An absolute path stays what it is.
    blends.push_back({.first = (from / listed.first()).string(),
                      .second = (from / listed.second()).string(),
                      .blend = OptionsOf(listed),
                      .name = listed.name()});
  }
  return blends;
}

std::string BlendName(absl::string_view first, absl::string_view second) {
  return absl::StrCat(ClipName(first), "_to_", ClipName(second));
}

}  // namespace sinew::import
