#include "tools/sinew/motion_blend.h"

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/blend_clips.h"
#include "sim/import/blend_list.h"
#include "sim/import/edit.h"
#include "sim/import/importer.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/run_import.h"

namespace sinew::tools {
namespace {

struct Options {
  ImportFlags flags;
  std::string first, second;  // both empty: list
  std::string list, root;
  double seconds = 0.5;
  std::vector<double> trim_first, trim_second;  // from, to, seconds
  std::vector<std::string> with;
};

import::KeptSeconds Kept(const std::vector<double>& trim) {
  if (trim.empty()) return {};
  return {.from_s = trim[0], .to_s = trim[1]};
}

absl::StatusOr<std::vector<import::BlendedFiles>> BlendsOf(
    const Options& options) {
  if (!options.list.empty()) {
    return import::ReadBlendList(options.list, options.root);
  }
  if (options.first.empty() || options.second.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("motion blend: expected two clips or --list, found ",
                     options.first.empty() ? "neither" : "one clip"));
  }
  return std::vector<import::BlendedFiles>{
      {.first = options.first,
       .second = options.second,
       .blend = {.gap_s = options.seconds,
                 .first = Kept(options.trim_first),
                 .second = Kept(options.trim_second)}}};
}

absl::Status Run(const Options& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(import::ImportOptions importing,
                         ImportOptionsOf(options.flags));
  SINEW_ASSIGN_OR_RETURN(importing.blends, BlendsOf(options));
  return RunImport(options.flags, options.with, importing, stop);
}

}  // namespace

void AddMotionBlend(CLI::App& motion, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = AddSubcommand<Options>(
      motion, "blend", "clips, joined in pairs over a gap, to a library",
      options, action, Run);
  AddImportFlags(command, &options->flags);
  const char* group = "How the clips are joined";
  auto* seconds =
      command
          ->add_option("--seconds", options->seconds,
                       absl::StrCat("length of the gap, at most ",
                                    import::kMostBlendGap, " (default 0.5)"))
          ->check(FiniteRange(0, import::kMostBlendGap))
          ->group(group);
  auto* trim_first =
      command
          ->add_option("--trim-first", options->trim_first,
                       "keep from, to of the first (two numbers, s)")
          ->expected(2)
          ->allow_extra_args(false)
          ->check(FiniteRange(0, 1e6))
          ->group(group);
  auto* trim_second =
      command
          ->add_option("--trim-second", options->trim_second, "of the second")
          ->expected(2)
          ->allow_extra_args(false)
          ->check(FiniteRange(0, 1e6))
          ->group(group);
  command
      ->add_option("--with", options->with,
                   "a clip, or a folder of them, that the library holds as "
                   "well; may be repeated")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(group);
  auto* first =
      command->add_option("first", options->first, "the clip to begin with");
  auto* second =
      command->add_option("second", options->second, "the clip to go on with");
  auto* list =
      command
          ->add_option("--list", options->list,
                       "in place of two clips: a file that lists pairs of "
                       "them (proto/sinew/v1/blend_list.proto)")
          ->group(group);
  for (auto* alone : {first, second, seconds, trim_first, trim_second}) {
    list->excludes(alone);
  }
  command
      ->add_option("--root", options->root,
                   "folder that the list's paths begin at (default: its own)")
      ->needs(list)
      ->group(group);
}

}  // namespace sinew::tools
