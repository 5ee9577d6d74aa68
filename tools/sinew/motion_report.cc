#include "tools/sinew/motion_report.h"

#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "tools/motion_report/motion_report.h"
#include "tools/sinew/finite_range.h"

namespace sinew::tools {
namespace {

struct Options {
  std::string library;
  std::string character;  // empty: the report's
  motion_report::MotionReportOptions page;
};

absl::Status Run(const Options& options, const StopToken& stop) {
  std::string name = options.character;
  if (name.empty()) {
    SINEW_ASSIGN_OR_RETURN(name,
                           motion_report::ReportedCharacter(options.library));
  }
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(name, WithDefaults(v1::Recipe()).physics()));
  SINEW_ASSIGN_OR_RETURN(const std::string path,
                         motion_report::WriteMotionReport(
                             *character, options.library, options.page, stop));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

}  // namespace

void AddMotionReport(CLI::App& motion, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = AddSubcommand<Options>(
      motion, "report", "a library's report.html", options, action, Run);
  command->add_option("library", options->library, "folder")->required();
  command->add_option("--character", options->character,
                      "name or file (default: the report's)");
  command->add_option("--pictures", options->page.pictures,
                      "clips with pictures (default: all)");
  command->add_option("--clips", options->page.clips,
                      "pictures and motion of these alone");
  command
      ->add_option("--megabytes", options->page.trajectory_megabytes,
                   "of motion in the page at most (default 60)")
      ->check(FiniteRange(0, 1e6));
}

}  // namespace sinew::tools
