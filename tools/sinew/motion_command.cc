#include "tools/sinew/motion_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/import/importer.h"
#include "tools/sinew/motion_inspect.h"
#include "tools/sinew/motion_render.h"

namespace sinew::tools {
namespace {

struct ImportOptions {
  std::string character = "humanoid";
  std::string out;
  std::vector<std::string> files;
  double rate = 30;  // frames per second
  std::string provenance;
  std::string licence;
};

void PrintClip(const import::ClipReport& report) {
  if (!report.status.ok()) {
    absl::PrintF("%-28s rejected: %s\n", report.file,
                 std::string(report.status.message()));
    return;
  }
  const v1::ClipQuality& quality = report.info.quality();
  absl::PrintF(
      "%-28s %5.2f s%s  fit %.3f/%.3f rad  residual %.2f bw %.0f Nm  "
      "torque %.2f  speed %.0f rad/s  skate %.1f cm/s  below floor %.1f cm\n",
      report.name, report.duration_s, report.info.loops() ? " loop" : "     ",
      quality.joint_fit_max_rad(), quality.joint_fit_mean_rad(),
      quality.residual_force_bodyweights(), quality.residual_torque_nm(),
      quality.peak_torque_ratio(), quality.peak_joint_speed(),
      100 * quality.foot_skate_m_per_s(), 100 * quality.penetration_max_m());
  for (const std::string& warning : report.warnings) {
    absl::PrintF("%-28s   %s\n", "", warning);
  }
}

absl::Status RunImport(const ImportOptions& options,
                       const StopToken& /*stop*/) {
  const v1::Physics physics = WithDefaults(v1::Recipe()).physics();
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(options.character, physics));
  import::ImportOptions importing;
  importing.rate = options.rate;
  importing.provenance = options.provenance;
  importing.licence = options.licence;
  std::vector<import::ClipReport> reports;
  const absl::Status status = import::ImportFiles(
      *character, options.files, importing, options.out, &reports);
  for (const import::ClipReport& report : reports) PrintClip(report);
  return status;
}

}  // namespace

void AddMotionCommand(CLI::App& app, Action& action) {
  auto* motion = app.add_subcommand("motion", "motion libraries");
  motion->require_subcommand(1);
  auto options = std::make_shared<ImportOptions>();
  auto* command = AddSubcommand<ImportOptions>(
      *motion, "import", "clips to a library", options, action, RunImport);
  command->add_option("--character", options->character, "name or file");
  command->add_option("--out", options->out, "library folder")->required();
  command->add_option("--rate", options->rate, "frames per second");
  command->add_option("--provenance", options->provenance,
                      "origin of the data");
  command->add_option("--licence", options->licence, "licence of the data");
  command->add_option("files", options->files, "clips")->required();
  AddMotionInspect(*motion, action);
  AddMotionRender(*motion, action);
}

}  // namespace sinew::tools
