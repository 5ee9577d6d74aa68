#include "tools/sinew/motion_inspect.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "sim/motion/library.h"

namespace sinew::tools {
namespace {

struct InspectOptions {
  std::string library;
};

constexpr char kLegend[] =
    "fit: largest joint angle lost to hinges; residual: root force that "
    "torques and floor\ncannot explain; torque: largest over its limit; "
    "definitions: sim/import/quality.h\n";

void PrintHead(const motion::Library& library, int name_width) {
  const v1::MotionLibrary& manifest = library.manifest();
  absl::PrintF("%d clips, %d frames at %g Hz, character %s, sha256 %s\n\n",
               library.num_clips(), manifest.num_frames(),
               manifest.frames_per_second(), manifest.character(),
               library.digest().substr(0, 12));
  absl::PrintF("%-*s %8s %5s %8s %9s %7s %8s %7s %7s  %s\n", name_width, "clip",
               "seconds", "loops", "fit rad", "resid. bw", "torque", "rad/s",
               "skate", "below", "licence");
  absl::PrintF("%*s %8s %5s %8s %9s %7s %8s %7s %7s\n", name_width, "", "", "",
               "", "", "x limit", "peak", "cm/s", "cm");
}

void PrintClip(const v1::ClipInfo& clip, double rate, int name_width) {
  const v1::ClipQuality& quality = clip.quality();
  absl::PrintF("%-*s %8.2f %5s %8.3f %9.2f %7.2f %8.1f %7.1f %7.1f  %s\n",
               name_width, clip.name(),
               static_cast<double>(clip.num_frames()) / rate,
               clip.loops() ? "yes" : "no", quality.joint_fit_max_rad(),
               quality.residual_force_bodyweights(),
               quality.peak_torque_ratio(), quality.peak_joint_speed(),
               100 * quality.foot_skate_m_per_s(),
               100 * quality.penetration_max_m(), clip.licence());
}

absl::Status RunInspect(const InspectOptions& options,
                        const StopToken& /*stop*/) {
  SINEW_ASSIGN_OR_RETURN(const auto library,
                         motion::Library::Load(options.library));
  size_t width = 4;
  for (const v1::ClipInfo& clip : library->manifest().clips()) {
    width = std::max(width, clip.name().size());
  }
  PrintHead(*library, static_cast<int>(width));
  for (const v1::ClipInfo& clip : library->manifest().clips()) {
    PrintClip(clip, library->manifest().frames_per_second(),
              static_cast<int>(width));
  }
  absl::PrintF("\n%s", kLegend);
  return absl::OkStatus();
}

}  // namespace

void AddMotionInspect(CLI::App& motion, Action& action) {
  auto options = std::make_shared<InspectOptions>();
  auto* command = AddSubcommand<InspectOptions>(
      motion, "inspect", "a table of a library's clips", options, action,
      RunInspect);
  command->add_option("library", options->library, "folder")->required();
}

}  // namespace sinew::tools
