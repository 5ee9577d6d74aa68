#include "tools/sinew/motion_import.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/import/importer.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/read_clip.h"
#include "tools/motion_report/motion_report.h"
#include "tools/training/progress.h"

namespace sinew::tools {
namespace {

struct Options {
  std::string character = "humanoid";
  std::string out;
  std::vector<std::string> files;
  double rate = 30;  // frames per second
  std::string provenance, licence;
  std::string format, asf, map;
  double unit = 0;  // metres; 0: not given
  std::string up;   // empty: not given
  double fps = 0;   // 0: not given
  std::string quaternion_order;
  std::vector<double> trim;  // from, to, seconds
  bool loop = false, mirror = false, align = false;
  double left_out_share = 0;
  int threads = 0;
  int pictures = 24;
  bool no_pictures = false, no_html = false, quiet = false;
  bool report_only = false;
};

absl::StatusOr<import::ImportOptions> Importing(const Options& options) {
  import::ImportOptions importing;
  importing.rate = options.rate;
  importing.provenance = options.provenance;
  importing.licence = options.licence;
  importing.threads = options.threads;
  importing.report_only = options.report_only;
  importing.left_out_share = options.left_out_share;
  importing.read.format = options.format;
  importing.read.asf = options.asf;
  import::ReadOptions& read = importing.read.read;
  if (options.unit > 0) read.metres_per_unit = options.unit;
  if (!options.up.empty()) read.up_axis = options.up[0];
  if (options.fps > 0) read.frames_per_second = options.fps;
  if (!options.quaternion_order.empty()) {
    read.quaternion_order = options.quaternion_order;
  }
  if (!options.trim.empty()) {
    importing.edits.from_s = options.trim[0];
    importing.edits.to_s = options.trim[1];
  }
  importing.edits.loop = options.loop;
  importing.edits.mirror = options.mirror;
  importing.edits.align_heading = options.align;
  if (!options.map.empty()) {
    SINEW_ASSIGN_OR_RETURN(importing.map, import::LoadSkeletonMap(options.map));
  }
  return importing;
}

std::string Cut(const std::string& text, size_t width) {
  if (text.size() <= width) return text;
  // Never within a character.
  size_t end = width - 3;
  while (end > 0 && (text[end] & 0xC0) == 0x80) --end;
  return absl::StrCat(text.substr(0, end), "...");
}

// Shows the import as it goes: a bar, and above it each file that is left out.
class Showing {
 public:
  explicit Showing(bool quiet)
      : quiet_(quiet),
        start_(clock_.SteadySeconds()),
        progress_({.is_terminal = isatty(STDERR_FILENO) == 1}, clock_) {}

  void Done(const import::ImportProgress& progress) {
    const import::ClipReport& last = *progress.last;
    const bool rejected = last.verdict.status == import::ClipStatus::kRejected;
    rejected_ += rejected;
    if (quiet_) return;
    if (rejected) {
      progress_.Line(absl::StrCat(
          "rejected  ",
          last.verdict.reason.find(last.file) == 0 ? "" : last.file + ": ",
          last.verdict.reason));
    }
    const double share = static_cast<double>(progress.done) / progress.total;
    const double passed = clock_.SteadySeconds() - start_;
    progress_.Show(share,
                   absl::StrFormat("%d of %d files, %d rejected, %s left  %s",
                                   progress.done, progress.total, rejected_,
                                   TimeText(passed * (1 / share - 1)),
                                   Cut(last.name, 32)));
  }

  void Picture(int done, int total) {
    if (quiet_) return;
    progress_.Show(static_cast<double>(done) / std::max(1, total),
                   absl::StrFormat("%d of %d picture strips", done, total));
  }

 private:
  const bool quiet_;
  const SystemClock clock_;
  const double start_;
  Progress progress_;
  int rejected_ = 0;
};

void PrintClip(const import::ClipReport& report, int width) {
  const v1::ClipQuality& quality = report.info.quality();
  absl::PrintF("%-8s  %-*s %7.2f %6.1f %6.1f %6.1f %6.1f %6.2f %6.2f  %s\n",
               import::StatusName(report.verdict.status), width, report.name,
               report.duration_s, 100 * quality.foot_skate_m_per_s(),
               100 * quality.penetration_max_m(),
               100 * quality.retarget_error_m(), quality.peak_joint_speed(),
               quality.residual_force_bodyweights(),
               quality.peak_torque_ratio(), report.verdict.reason);
}

void PrintTable(const std::vector<import::ClipReport>& reports) {
  size_t width = 4;
  for (const auto& report : reports) {
    width = std::max(width, std::min<size_t>(48, report.name.size()));
  }
  absl::PrintF("%-8s  %-*s %7s %6s %6s %6s %6s %6s %6s\n", "status",
               static_cast<int>(width), "clip", "seconds", "skate", "floor",
               "error", "rad/s", "force", "torque");
  absl::PrintF("%-8s  %-*s %7s %6s %6s %6s %6s %6s %6s\n", "",
               static_cast<int>(width), "", "", "cm/s", "cm", "cm", "peak",
               "bw", "x lim");
  for (const auto& report : reports) {
    if (report.measured()) {
      PrintClip(report, static_cast<int>(width));
    } else {
      absl::PrintF("%-8s  %-*s %s\n", "rejected", static_cast<int>(width),
                   report.name, report.verdict.reason);
    }
  }
}

void PrintSummary(const std::vector<import::ClipReport>& reports) {
  int ok = 0, warned = 0, rejected = 0, cached = 0;
  int left_out = 0;
  double seconds = 0, core_seconds = 0;
  for (const auto& report : reports) {
    left_out += report.status.ok() && report.info.left_out();
    ok += report.verdict.status == import::ClipStatus::kOk;
    warned += report.verdict.status == import::ClipStatus::kWarned;
    rejected += report.verdict.status == import::ClipStatus::kRejected;
    cached += report.from_cache;
    if (report.status.ok()) seconds += report.duration_s;
    if (!report.from_cache) core_seconds += report.core_seconds;
  }
  absl::PrintF(
      "\n%d ok, %d warned, %d rejected; %.1f minutes of motion are good "
      "enough for the library; %.1f core-seconds%s\n",
      ok, warned, rejected, seconds / 60, core_seconds,
      cached > 0
          ? absl::StrFormat(", %d unchanged files not read again", cached)
          : "");
  if (left_out > 0) {
    absl::PrintF("%d clips are left out of training, for evaluation alone\n",
                 left_out);
  }
}

absl::Status WritePage(const character::Character& character,
                       const Options& options, Showing* showing,
                       const StopToken& stop) {
  motion_report::MotionReportOptions page;
  page.pictures = options.no_pictures ? 0 : options.pictures;
  page.on_picture = [showing](int done, int total) {
    showing->Picture(done, total);
  };
  SINEW_ASSIGN_OR_RETURN(
      const std::string path,
      motion_report::WriteMotionReport(character, options.out, page, stop));
  absl::PrintF("%s\n", path);
  return absl::OkStatus();
}

absl::Status Run(const Options& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(options.character,
                                 WithDefaults(v1::Recipe()).physics()));
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> files,
                         import::ExpandFolders(options.files));
  SINEW_ASSIGN_OR_RETURN(import::ImportOptions importing, Importing(options));
  auto showing = std::make_unique<Showing>(options.quiet);
  importing.stop = stop;
  importing.on_progress = [&](const import::ImportProgress& progress) {
    showing->Done(progress);
  };
  std::vector<import::ClipReport> reports;
  bool changed = false;
  importing.changed = &changed;
  const absl::Status imported =
      import::ImportFiles(*character, files, importing, options.out, &reports);
  if (absl::IsCancelled(imported)) return imported;
  const std::string page = JoinPath(options.out, "report.html");
  // Of what the folder held before.
  if (changed) SINEW_RETURN_IF_ERROR(RemoveRecursively(page));
  // Ends the bar's line before the table.
  showing = std::make_unique<Showing>(options.quiet);
  if (!options.quiet) PrintTable(reports);
  if (imported.ok()) PrintSummary(reports);
  // Where nothing is good enough for the library, there are reasons to be read.
  const bool reported =
      imported.ok() || (absl::IsInvalidArgument(imported) && !reports.empty());
  if (reported && !options.no_html && (changed || !FileExists(page))) {
    SINEW_RETURN_IF_ERROR(WritePage(*character, options, showing.get(), stop));
  }
  return imported;
}

void AddReading(CLI::App* command, Options* options) {
  const char* group = "What the files do not say";
  command
      ->add_option("--format", options->format,
                   "bvh, asf_amc, smpl_npz, deepmimic, robot_csv, keyframes, "
                   "fbx (default: by content and name)")
      ->group(group);
  command
      ->add_option("--unit", options->unit,
                   "metres per unit of length (default: concluded)")
      ->check(CLI::PositiveNumber)
      ->group(group);
  command->add_option("--up", options->up, "axis that points up: x, y or z")
      ->check(CLI::IsMember({"x", "y", "z"}))
      ->group(group);
  command->add_option("--fps", options->fps, "frames per second of the files")
      ->check(CLI::PositiveNumber)
      ->group(group);
  command
      ->add_option("--quaternion-order", options->quaternion_order,
                   "of CSV files: wxyz or xyzw (default: by kinematics)")
      ->check(CLI::IsMember({"wxyz", "xyzw"}))
      ->group(group);
  command
      ->add_option("--asf", options->asf,
                   "skeleton of AMC files (default: beside each)")
      ->group(group);
  command
      ->add_option("--map", options->map,
                   "skeleton map: name or file (default: found or drafted)")
      ->group(group);
}

void AddEditing(CLI::App* command, Options* options) {
  const char* group = "What to do with every clip";
  command->add_option("--trim", options->trim, "keep from, to (two numbers, s)")
      ->expected(2)
      ->group(group);
  command
      ->add_flag("--loop", options->loop,
                 "keep the frames that repeat best, as a loop")
      ->group(group);
  command
      ->add_flag("--mirror", options->mirror,
                 "add its mirror image, as NAME_mirror")
      ->group(group);
  command
      ->add_flag("--align", options->align,
                 "begin at the origin, looking along x")
      ->group(group);
}

}  // namespace

void AddMotionImport(CLI::App& motion, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = AddSubcommand<Options>(motion, "import", "clips to a library",
                                         options, action, Run);
  command->add_option("--character", options->character, "name or file");
  command->add_option("--out", options->out, "library folder")->required();
  command->add_option("--rate", options->rate,
                      "frames per second of the library");
  command->add_option("--provenance", options->provenance,
                      "origin of the data");
  command->add_option("--licence", options->licence, "licence of the data");
  AddReading(command, options.get());
  AddEditing(command, options.get());
  command
      ->add_option("--left-out-share", options->left_out_share,
                   "share of the recordings that is left out of training, by a "
                   "hash of each (0.15 is usual)")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--threads", options->threads, "default: all processors");
  command->add_option("--pictures", options->pictures,
                      "clips in report.html with pictures (default 24)");
  command->add_flag("--no-pictures", options->no_pictures, "none of them");
  command->add_flag("--no-html", options->no_html, "no report.html");
  command->add_flag("--report-only", options->report_only,
                    "report.json and report.html, no library");
  command->add_flag("--quiet", options->quiet, "no progress, no table");
  command->add_option("files", options->files, "clips, or folders of them")
      ->required();
}

}  // namespace sinew::tools
