#include "tools/sinew/report_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "tools/report/report.h"
#include "tools/training/shown_folder.h"

namespace sinew::tools {
namespace {

absl::Status RunReport(const report::ReportOptions& asked,
                       const StopToken& stop) {
  report::ReportOptions options = asked;
  options.run = FolderWithRows(asked.run);
  SINEW_ASSIGN_OR_RETURN(const std::string path,
                         report::WriteReport(options, stop));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

}  // namespace

void AddReportCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<report::ReportOptions>();
  auto* command = AddSubcommand<report::ReportOptions>(
      app, "report", "a run as one HTML file", options, action, RunReport);
  command
      ->add_option("--run", options->run,
                   "run directory; of a procedure: its newest stage with rows")
      ->required();
  command->add_option("--motions", options->motions,
                      "library (default: that of eval.json)");
  command->add_option("--clip", options->clip,
                      "shown in motion (default: the first)");
  command->add_option("--out", options->out,
                      "file (default: report.html in the run)");
}

}  // namespace sinew::tools
