#include "tools/sinew/motion_map.h"

#include <cstdio>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/read_clip.h"

namespace sinew::tools {
namespace {

struct Options {
  std::string file;
  import::ReadClipOptions read;
  std::string name = "draft";
  bool draft = false;
};

absl::Status Run(const Options& options, const StopToken& /*stop*/) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadFile(options.file, import::kMaxClipBytes));
  SINEW_ASSIGN_OR_RETURN(const import::Source source,
                         import::ReadClip(options.file, bytes, "clip",
                                          /*model=*/nullptr, options.read));
  const auto* clip = std::get_if<import::SourceClip>(&source);
  if (clip == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(options.file,
                     ": a robot's recording: its joints have names, no roles"));
  }
  if (!options.draft) {
    SINEW_ASSIGN_OR_RETURN(const std::vector<v1::SkeletonMap> maps,
                           import::KnownSkeletonMaps());
    const v1::SkeletonMap* known = import::FindMapFor(maps, clip->skeleton);
    if (known != nullptr) {
      absl::FPrintF(stderr, "the map %s fits\n", known->name());
      absl::PrintF("%s", import::SkeletonMapText(*known));
      return absl::OkStatus();
    }
  }
  SINEW_ASSIGN_OR_RETURN(
      const v1::SkeletonMap draft,
      import::DraftSkeletonMap(clip->skeleton, options.name));
  absl::PrintF("%s", import::SkeletonMapText(draft));
  return absl::OkStatus();
}

}  // namespace

void AddMotionMap(CLI::App& motion, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = AddSubcommand<Options>(
      motion, "map", "which joint of a file is what, for editing", options,
      action, Run);
  command->add_option("file", options->file, "a clip")->required();
  command->add_flag("--draft", options->draft,
                    "draft a map also if a known one fits");
  command->add_option("--name", options->name, "of the drafted map");
  command->add_option("--format", options->read.format,
                      "as of import (default: by content and name)");
  command->add_option("--asf", options->read.asf,
                      "skeleton of an AMC file (default: beside it)");
}

}  // namespace sinew::tools
