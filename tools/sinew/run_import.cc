#include "tools/sinew/run_import.h"

#include <unistd.h>

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/import/read_clip.h"
#include "tools/motion_report/motion_report.h"
#include "tools/sinew/finite_range.h"
#include "tools/training/progress.h"

namespace sinew::tools {
namespace {

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
                   absl::StrFormat("%d of %d clips, %d rejected, %s left  %s",
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
  int ok = 0, warned = 0, rejected = 0, cached = 0, left_out = 0;
  double seconds = 0, core_seconds = 0;
  for (const auto& report : reports) {
    ok += report.verdict.status == import::ClipStatus::kOk;
    warned += report.verdict.status == import::ClipStatus::kWarned;
    rejected += report.verdict.status == import::ClipStatus::kRejected;
    cached += report.from_cache;
    left_out += report.status.ok() && report.info.left_out();
    if (report.status.ok()) seconds += report.duration_s;
    if (!report.from_cache) core_seconds += report.core_seconds;
  }
  const std::string motion =
      seconds < 120 ? absl::StrFormat("%.1f seconds", seconds)
                    : absl::StrFormat("%.1f minutes", seconds / 60);
  absl::PrintF(
      "\n%d ok, %d warned, %d rejected; %s of motion are good enough for the "
      "library; %.1f core-seconds%s\n",
      ok, warned, rejected, motion, core_seconds,
      cached > 0
          ? absl::StrFormat(", %d unchanged files not read again", cached)
          : "");
  if (left_out > 0) {
    absl::PrintF("%d clips are left out of training, for evaluation alone\n",
                 left_out);
  }
}

absl::Status WritePage(const character::Character& character,
                       const ImportFlags& options, Showing* showing,
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

void AddReading(CLI::App* command, ImportFlags* options) {
  const char* group = "What the files do not say";
  command
      ->add_option("--format", options->format,
                   "bvh, asf_amc, smpl_npz, deepmimic, robot_csv, keyframes, "
                   "fbx (default: by content and name)")
      ->group(group);
  command
      ->add_option("--unit", options->unit,
                   "metres per unit of length (default: concluded)")
      ->check(FiniteRange(1e-6, 1e3))
      ->group(group);
  command->add_option("--up", options->up, "axis that points up: x, y or z")
      ->check(CLI::IsMember({"x", "y", "z"}))
      ->group(group);
  command->add_option("--fps", options->fps, "frames per second of the files")
      ->check(FiniteRange(1e-3, 1e4))
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

void AddShowing(CLI::App* command, ImportFlags* flags) {
  command->add_option("--threads", flags->threads, "default: all processors")
      ->check(ThreadRange());
  command->add_option("--pictures", flags->pictures,
                      "clips in report.html with pictures (default: all)");
  command->add_flag("--no-pictures", flags->no_pictures, "none of them");
  command->add_flag("--no-html", flags->no_html, "no report.html");
  command->add_flag("--report-only", flags->report_only,
                    "report.json and report.html, no library");
  command->add_flag("--quiet", flags->quiet, "no progress, no table");
}

}  // namespace

void AddImportFlags(CLI::App* command, ImportFlags* flags) {
  command->add_option("--character", flags->character,
                      "name of one, or a file");
  command->add_option("--out", flags->out, "library folder")->required();
  command->add_option("--rate", flags->rate, "frames per second of the library")
      ->check(FiniteRange(0, 1000));
  command->add_option("--provenance", flags->provenance, "origin of the data");
  command->add_option("--licence", flags->licence, "licence of the data");
  command
      ->add_option("--credit", flags->credits,
                   "PATH PROVENANCE LICENCE: those of one file, or of all "
                   "below a folder; may be given several times")
      ->allow_extra_args(false);
  AddReading(command, flags);
  const char* group = "What to do with every clip";
  CLI::Option* mirror = command
                            ->add_flag("--mirror", flags->mirror,
                                       "add its mirror image, as NAME_mirror")
                            ->group(group);
  command
      ->add_option(
          "--mirror-within", flags->mirror_within,
          "PATH: add the mirror image of one file, or of all below a "
          "folder, alone (of a blend where one of its two is); may be given "
          "several times")
      ->allow_extra_args(false)
      ->excludes(mirror)
      ->group(group);
  command
      ->add_flag("--align", flags->align,
                 "begin at the origin, looking along x")
      ->group(group);
  command
      ->add_option("--left-out-share", flags->left_out_share,
                   "share of the recordings that is left out of training, by a "
                   "hash of each (0.15 is usual)")
      ->check(FiniteRange(0, 1))
      ->capture_default_str();
  AddShowing(command, flags);
}

absl::StatusOr<import::ImportOptions> ImportOptionsOf(
    const ImportFlags& flags) {
  import::ImportOptions options;
  options.rate = flags.rate;
  options.credit = {flags.provenance, flags.licence};
  for (const auto& [path, provenance, licence] : flags.credits) {
    options.credits.push_back({path, {provenance, licence}});
  }
  options.threads = flags.threads;
  options.report_only = flags.report_only;
  options.left_out_share = flags.left_out_share;
  options.read.format = flags.format;
  options.read.asf = flags.asf;
  import::ReadOptions& read = options.read.read;
  if (flags.unit > 0) read.metres_per_unit = flags.unit;
  if (!flags.up.empty()) read.up_axis = flags.up[0];
  if (flags.fps > 0) read.frames_per_second = flags.fps;
  if (!flags.quaternion_order.empty()) {
    read.quaternion_order = flags.quaternion_order;
  }
  options.edits.mirror = flags.mirror || !flags.mirror_within.empty();
  options.mirror_within = flags.mirror_within;
  options.edits.align_heading = flags.align;
  if (!flags.map.empty()) {
    SINEW_ASSIGN_OR_RETURN(options.map, import::LoadSkeletonMap(flags.map));
  }
  return options;
}

absl::Status RunImport(const ImportFlags& flags,
                       const std::vector<std::string>& files,
                       import::ImportOptions options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(
      const auto character,
      character::Character::Load(flags.character,
                                 WithDefaults(v1::Recipe()).physics()));
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> expanded,
                         import::ExpandFolders(files));
  auto showing = std::make_unique<Showing>(flags.quiet);
  options.stop = stop;
  options.on_progress = [&](const import::ImportProgress& progress) {
    showing->Done(progress);
  };
  std::vector<import::ClipReport> reports;
  bool changed = false;
  options.changed = &changed;
  const absl::Status imported =
      import::ImportFiles(*character, expanded, options, flags.out, &reports);
  if (absl::IsCancelled(imported)) return imported;
  const std::string page = JoinPath(flags.out, "report.html");
  // Of what the folder held before.
  if (changed) SINEW_RETURN_IF_ERROR(RemoveRecursively(page));
  // Ends the bar's line before the table.
  showing = std::make_unique<Showing>(flags.quiet);
  if (!flags.quiet) PrintTable(reports);
  if (imported.ok()) PrintSummary(reports);
  // Where nothing is good enough for the library, there are reasons to be read.
  const bool reported =
      imported.ok() || (absl::IsInvalidArgument(imported) && !reports.empty());
  if (reported && !flags.no_html && (changed || !FileExists(page))) {
    SINEW_RETURN_IF_ERROR(WritePage(*character, flags, showing.get(), stop));
  }
  return imported;
}

}  // namespace sinew::tools
