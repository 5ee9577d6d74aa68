#include "sim/import/detect_format.h"

#include <array>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"

namespace sinew::import {
namespace {

constexpr std::array<std::pair<ClipFormat, absl::string_view>, 8> kNames = {{
    {ClipFormat::kBvh, "bvh"},
    {ClipFormat::kAsfAmc, "asf_amc"},
    {ClipFormat::kSmplNpz, "smpl_npz"},
    {ClipFormat::kRobotNpz, "robot_npz"},
    {ClipFormat::kDeepMimic, "deepmimic"},
    {ClipFormat::kRobotCsv, "robot_csv"},
    {ClipFormat::kKeyframes, "keyframes"},
    {ClipFormat::kFbx, "fbx"},
}};

constexpr absl::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr absl::string_view kZip = "PK\x03\x04";

absl::Status NoClip(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": expected a motion clip, found ", what));
}

// What a zip file of arrays holds; names of members stand in it as they are.
absl::StatusOr<ClipFormat> DetectArrays(const std::string& path,
                                        absl::string_view bytes) {
  const auto has = [&](absl::string_view member) {
    return absl::StrContains(bytes, member);
  };
  if (has("joint_pos.npy") || has("body_pos_w.npy")) {
    return ClipFormat::kRobotNpz;
  }
  if (has("poses.npy") || has("trans.npy") || has("root_orient.npy") ||
      LowerCaseExtension(path) == ".npz") {
    return ClipFormat::kSmplNpz;
  }
  return NoClip(path, "a zip file without arrays of poses");
}

absl::StatusOr<ClipFormat> DetectJson(const std::string& path,
                                      absl::string_view text) {
  const auto has = [&](absl::string_view key) {
    return absl::StrContains(text, absl::StrCat("\"", key, "\""));
  };
  if (has("LoopMode") || has("FrameDuration")) {
    return NoClip(path,
                  "JSON of a robot dog (LoopMode, FrameDuration): no human "
                  "body, no known robot");
  }
  if (has("Skeleton") && has("Joints")) {
    return NoClip(path, "JSON of a skeleton (\"Skeleton\") without motion");
  }
  return ClipFormat::kDeepMimic;
}

absl::StatusOr<ClipFormat> DetectXml(const std::string& path,
                                     absl::string_view text) {
  if (absl::StrContains(text, kKeyframeTag)) return ClipFormat::kKeyframes;
  return NoClip(path, "XML without <keyframe>");
}

// By signature; unset where the content says nothing.
std::optional<absl::StatusOr<ClipFormat>> DetectContent(
    const std::string& path, absl::string_view bytes) {
  absl::string_view text = absl::StripPrefix(bytes, kByteOrderMark);
  text = absl::StripLeadingAsciiWhitespace(text);
  if (absl::StartsWith(bytes, "Kaydara FBX Binary") ||
      absl::StartsWith(text, "; FBX")) {
    return ClipFormat::kFbx;
  }
  if (absl::StartsWith(bytes, kZip)) return DetectArrays(path, bytes);
  if (absl::StartsWithIgnoreCase(text, "HIERARCHY")) return ClipFormat::kBvh;
  if (absl::StartsWith(text, "{")) return DetectJson(path, text);
  if (absl::StartsWith(text, "<")) return DetectXml(path, text);
  // Comments come before it.
  const absl::string_view head = text.substr(0, 4096);
  if (absl::StrContains(head, ":FULLY-SPECIFIED") ||
      absl::StrContains(head, ":DEGREES")) {
    return ClipFormat::kAsfAmc;
  }
  return std::nullopt;
}

absl::StatusOr<ClipFormat> DetectExtension(const std::string& path) {
  const std::string extension = LowerCaseExtension(path);
  if (extension == ".bvh") return ClipFormat::kBvh;
  if (extension == ".amc") return ClipFormat::kAsfAmc;
  if (extension == ".npz") return ClipFormat::kSmplNpz;
  if (extension == ".csv") return ClipFormat::kRobotCsv;
  if (extension == ".fbx") return ClipFormat::kFbx;
  if (extension == ".txt" || extension == ".json") {
    return ClipFormat::kDeepMimic;
  }
  if (extension == ".xml") return ClipFormat::kKeyframes;
  if (extension == ".asf") {
    return NoClip(path, "a skeleton (ASF); give the .amc files beside it");
  }
  if (extension == ".c3d") {
    return NoClip(path,
                  "marker positions (C3D) without skeleton; solve them to "
                  "joint angles (BVH, ASF/AMC, FBX) first");
  }
  if (extension == ".pkl" || extension == ".pt" || extension == ".npy") {
    return NoClip(path, absl::StrCat("a Python object (", extension,
                                     "); save it as npz or csv"));
  }
  return NoClip(path, "an unknown kind of file (by extension and content)");
}

}  // namespace

absl::string_view FormatName(ClipFormat format) {
  for (const auto& [value, name] : kNames) {
    if (value == format) return name;
  }
  return "unknown";
}

absl::StatusOr<ClipFormat> FormatOfName(absl::string_view name) {
  const auto second = [](std::string* out, const auto& pair) {
    absl::StrAppend(out, pair.second);
  };
  for (const auto& [value, known] : kNames) {
    if (known == name) return value;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "format: expected one of ", absl::StrJoin(kNames, ", ", second),
      "; found \"", name, "\""));
}

absl::StatusOr<ClipFormat> DetectFormat(const std::string& path,
                                        absl::string_view bytes) {
  if (bytes.empty()) return NoClip(path, "an empty file");
  // C3D is told apart by its name: its signature is a single byte.
  if (LowerCaseExtension(path) == ".c3d") return DetectExtension(path);
  if (auto found = DetectContent(path, bytes)) return *found;
  return DetectExtension(path);
}

std::string LowerCaseExtension(absl::string_view path) {
  const absl::string_view base = path.substr(path.find_last_of('/') + 1);
  const size_t dot = base.find_last_of('.');
  if (dot == absl::string_view::npos || dot == 0) return "";
  return absl::AsciiStrToLower(base.substr(dot));
}

}  // namespace sinew::import
