// Imports clips to a library, for whoever has no use for the whole command:
//   import_tool --character humanoid --out DIR FILES...
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "sim/import/importer.h"

int main(int argc, char** argv) {
  CLI::App app("Imports motion clips");
  std::string character = "humanoid";
  std::string out;
  std::vector<std::string> files;
  sinew::import::ImportOptions options;
  app.add_option("--character", character);
  app.add_option("--out", out)->required();
  app.add_option("--rate", options.rate);
  app.add_option("files", files)->required();
  CLI11_PARSE(app, argc, argv);

  const auto body =
      sinew::character::Character::Load(character, sinew::v1::Physics());
  if (!body.ok()) {
    absl::PrintF("%s\n", std::string(body.status().message()));
    return 2;
  }
  std::vector<sinew::import::ClipReport> reports;
  const absl::Status status =
      sinew::import::ImportFiles(**body, files, options, out, &reports);
  absl::PrintF(
      "clip                        s    n  fit max  mean   force torque   peak "
      "   pen  float  speed  skate   seam\n");
  for (const sinew::import::ClipReport& report : reports) {
    const auto& q = report.info.quality();
    if (!report.status.ok()) {
      absl::PrintF("%s\n", std::string(report.status.message()));
      continue;
    }
    absl::PrintF(
        "%-25s %4.2f %4d   %.3f  %.3f   %.3f %6.1f  %5.2f  %.3f  %.3f  %5.1f  "
        "%.3f  %.3f\n",
        report.name, report.duration_s, report.info.num_frames(),
        q.joint_fit_max_rad(), q.joint_fit_mean_rad(),
        q.residual_force_bodyweights(), q.residual_torque_nm(),
        q.peak_torque_ratio(), q.penetration_max_m(), q.floating_mean_m(),
        q.peak_joint_speed(), q.foot_skate_m_per_s(), q.loop_seam_m());
    for (const std::string& warning : report.warnings) {
      absl::PrintF("    %s\n", warning);
    }
  }
  if (status.ok()) return 0;
  absl::PrintF("%s\n", std::string(status.message()));
  return 1;
}
