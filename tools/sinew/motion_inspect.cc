#include "tools/sinew/motion_inspect.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/status_macros.h"
#include "sim/import/quality_gate.h"
#include "sim/motion/library.h"
#include "tools/evaluation/subject.h"

namespace sinew::tools {
namespace {

struct InspectOptions {
  std::string library;
  std::string clip;  // empty: a table of all
};

constexpr char kLegend[] =
    "error: mean distance of hands, feet and head from the scaled source; "
    "force: root force that\ntorques and floor cannot explain; torque: largest "
    "over its limit; limits: angles that the source\nputs beyond them; "
    "definitions: sim/import/retarget/quality.h, limits: "
    "sim/import/quality_gate.h\n";

void PrintHead(const motion::Library& library, int name_width) {
  const v1::MotionLibrary& manifest = library.manifest();
  absl::PrintF("%d clips, %d frames at %g Hz, character %s, sha256 %s\n\n",
               library.num_clips(), manifest.num_frames(),
               manifest.frames_per_second(), manifest.character(),
               library.digest().substr(0, 12));
  absl::PrintF("%-*s %8s %5s %-10s %6s %6s %6s %6s %6s %6s %6s %7s  %s\n",
               name_width, "clip", "seconds", "loops", "source", "error",
               "force", "torque", "speed", "skate", "below", "limits", "status",
               "licence");
  absl::PrintF("%-*s %8s %5s %-10s %6s %6s %6s %6s %6s %6s %6s\n", name_width,
               "", "", "", "", "cm", "bw", "x lim", "rad/s", "cm/s", "cm", "%");
}

void PrintClip(const v1::ClipInfo& clip, double rate, int name_width) {
  const v1::ClipQuality& quality = clip.quality();
  absl::PrintF(
      "%-*s %8.2f %5s %-10s %6.1f %6.2f %6.2f %6.1f %6.1f %6.1f %6.1f %7s  "
      "%s\n",
      name_width, clip.name(), static_cast<double>(clip.num_frames()) / rate,
      clip.loops() ? "yes" : "no",
      clip.source().format().empty() ? "-" : clip.source().format(),
      100 * quality.retarget_error_m(), quality.residual_force_bodyweights(),
      quality.peak_torque_ratio(), quality.peak_joint_speed(),
      100 * quality.foot_skate_m_per_s(), 100 * quality.penetration_max_m(),
      100 * quality.joint_limit_violation_share(),
      import::StatusName(import::JudgeQuality(quality).status), clip.licence());
}

void PrintTable(const motion::Library& library) {
  size_t width = 4;
  for (const v1::ClipInfo& clip : library.manifest().clips()) {
    width = std::max(width, clip.name().size());
  }
  PrintHead(library, static_cast<int>(width));
  for (const v1::ClipInfo& clip : library.manifest().clips()) {
    PrintClip(clip, library.manifest().frames_per_second(),
              static_cast<int>(width));
  }
  absl::PrintF("\n%s", kLegend);
}

void PrintLine(const std::string& name, const std::string& value) {
  if (!value.empty()) absl::PrintF("%-22s %s\n", name, value);
}

// "120 (concluded)"
std::string Fact(const v1::ClipSource& source, const std::string& field,
                 const std::string& value) {
  const auto& concluded = source.concluded();
  const bool guessed =
      std::find(concluded.begin(), concluded.end(), field) != concluded.end();
  return value.empty() || !guessed ? value
                                   : absl::StrCat(value, " (concluded)");
}

void PrintSource(const v1::ClipInfo& clip) {
  const v1::ClipSource& source = clip.source();
  PrintLine("file", clip.source_file());
  PrintLine("sha256", clip.source_sha256());
  PrintLine("recording", clip.trial());
  PrintLine("mirror image of", clip.mirror_of());
  if (clip.has_blend()) {
    PrintLine("followed after",
              absl::StrFormat("%g s by %s", clip.blend().gap_s(),
                              clip.blend().source_file()));
    PrintLine("its recording", clip.blend().trial());
  }
  PrintLine("left out of training", clip.left_out() ? "yes" : "");
  PrintLine("provenance", clip.provenance());
  PrintLine("licence", clip.licence());
  PrintLine("format", source.format());
  PrintLine("map or layout", source.map());
  PrintLine("frames per second",
            Fact(source, "frames_per_second",
                 absl::StrFormat("%g", source.frames_per_second())));
  PrintLine("metres per unit",
            Fact(source, "metres_per_unit",
                 absl::StrFormat("%g", source.metres_per_unit())));
  PrintLine("up axis", Fact(source, "up_axis", source.up_axis()));
  PrintLine("quaternion order",
            Fact(source, "quaternion_order", source.quaternion_order()));
}

void PrintDetails(const v1::ClipInfo& clip, double rate) {
  PrintLine("clip", clip.name());
  PrintLine("frames", absl::StrFormat("%d, %.2f s%s", clip.num_frames(),
                                      clip.num_frames() / rate,
                                      clip.loops() ? ", loops" : ""));
  PrintSource(clip);
  const import::Verdict verdict = import::JudgeQuality(clip.quality());
  PrintLine("status", absl::StrCat(import::StatusName(verdict.status),
                                   verdict.findings.empty() ? "" : ": ",
                                   absl::StrJoin(verdict.findings, "; ")));
  for (const import::QualityLimit& limit : import::QualityLimits()) {
    absl::PrintF("  %-52s %8.3g %s\n", limit.figure,
                 limit.scale * limit.value(clip.quality()), limit.unit);
  }
  for (const v1::RetargetError& error : clip.quality().retarget_errors()) {
    absl::PrintF("  error of %-43s %8.1f cm, at most %.1f cm\n", error.joint(),
                 100 * error.mean_m(), 100 * error.max_m());
  }
}

absl::Status RunInspect(const InspectOptions& options,
                        const StopToken& /*stop*/) {
  SINEW_ASSIGN_OR_RETURN(const auto library,
                         motion::Library::Load(options.library));
  if (options.clip.empty()) {
    PrintTable(*library);
    return absl::OkStatus();
  }
  SINEW_ASSIGN_OR_RETURN(const int clip,
                         evaluation::FindClip(*library, options.clip));
  PrintDetails(library->clip(clip), library->manifest().frames_per_second());
  return absl::OkStatus();
}

}  // namespace

void AddMotionInspect(CLI::App& motion, Action& action) {
  auto options = std::make_shared<InspectOptions>();
  auto* command = AddSubcommand<InspectOptions>(motion, "inspect",
                                                "a table of a library's clips",
                                                options, action, RunInspect);
  command->add_option("library", options->library, "folder")->required();
  command->add_option("--clip", options->clip, "all that is known of this one");
}

}  // namespace sinew::tools
