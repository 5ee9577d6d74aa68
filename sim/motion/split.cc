#include "sim/motion/split.h"

#include <cstdint>
#include <filesystem>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/check.h"
#include "common/digest.h"

namespace sinew::motion {
namespace {

std::string Key(const std::string& trial, const std::string& name) {
  if (!trial.empty()) return trial;
  return std::string(absl::StripSuffix(name, "_mirror"));
}

// Of the second part of a clip that was joined from two.
std::string BlendKey(const v1::BlendedClip& blend) {
  const std::filesystem::path file(blend.source_file());
  return Key(blend.trial(), file.stem().string());
}

}  // namespace

std::string SplitKey(const v1::ClipInfo& clip) {
  return Key(clip.trial(),
             clip.mirror_of().empty() ? clip.name() : clip.mirror_of());
}

bool IsLeftOut(absl::string_view split_key, double share) {
  // 52 bits are a fraction without rounding.
  constexpr size_t kDigits = 13;
  const std::string digest = Sha256Hex(absl::StrCat("split:", split_key));
  uint64_t number = 0;
  SINEW_CHECK(absl::SimpleHexAtoi(digest.substr(0, kDigits), &number));
  return static_cast<double>(number) / (uint64_t{1} << (4 * kDigits)) < share;
}

bool IsLeftOut(const v1::ClipInfo& clip, double share) {
  return IsLeftOut(SplitKey(clip), share) ||
         (clip.has_blend() && IsLeftOut(BlendKey(clip.blend()), share));
}

}  // namespace sinew::motion
