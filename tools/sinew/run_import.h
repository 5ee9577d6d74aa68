#ifndef SINEW_TOOLS_SINEW_RUN_IMPORT_H_
#define SINEW_TOOLS_SINEW_RUN_IMPORT_H_

#include <CLI/CLI.hpp>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"
#include "sim/import/importer.h"

namespace sinew::tools {

// What `sinew motion import` and `sinew motion blend` share: how files are
// read, where the library goes, what is shown meanwhile and reported at the
// end.
//
// Thread-safety: one thread. Ownership: AddImportFlags borrows the flags until
// parsing is over. Blocking: RunImport as import::ImportFiles. Errors: those of
// ImportFiles, of loading character and map, and of writing the report.
struct ImportFlags {
  std::string character = "humanoid";
  std::string out;
  double rate = 30;  // frames per second
  std::string provenance, licence;
  // Path, provenance, licence.
  std::vector<std::tuple<std::string, std::string, std::string>> credits;
  std::string format, asf, map;
  double unit = 0;  // metres; 0: not given
  std::string up;   // empty: not given
  double fps = 0;   // 0: not given
  std::string quaternion_order;
  bool mirror = false, align = false;
  std::vector<std::string> mirror_within;
  double left_out_share = 0;
  int threads = 0;
  int pictures = std::numeric_limits<int>::max();
  bool no_pictures = false, no_html = false, quiet = false;
  bool report_only = false;
};

void AddImportFlags(CLI::App* command, ImportFlags* flags);

// All that flags say; what else is to be done is added by the caller.
absl::StatusOr<import::ImportOptions> ImportOptionsOf(const ImportFlags& flags);

// Imports the files (folders are walked) and options.blends with a progress
// bar, a table and report.html. Fails where nothing could be imported; the
// report is written all the same.
absl::Status RunImport(const ImportFlags& flags,
                       const std::vector<std::string>& files,
                       import::ImportOptions options, const StopToken& stop);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_RUN_IMPORT_H_
