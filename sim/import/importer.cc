#include "sim/import/importer.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/cpu.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/mutex.h"
#include "common/status_macros.h"
#include "sim/import/blend_clips.h"
#include "sim/import/clip_cache.h"
#include "sim/import/clip_name.h"
#include "sim/import/import_job.h"
#include "sim/import/library_writer.h"
#include "sim/import/parallel.h"
#include "sim/motion/library.h"
#include "sim/motion/library_check.h"

namespace sinew::import {
namespace {

using Json = nlohmann::json;

constexpr char kCacheFolder[] = "cache";
constexpr char kReportFile[] = "report.json";
constexpr char kImportFile[] = "import.json";
constexpr char kManifestFile[] = "manifest.json";
constexpr int64_t kMaxJsonBytes = int64_t{1} << 30;

absl::Status Check(const ImportOptions& options, const ImportModel& model,
                   const std::string& character) {
  if (!(options.rate > 0 && options.rate <= 1000)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rate: expected > 0 and at most 1000 frames per second, found ",
        options.rate));
  }
  if (!(options.left_out_share >= 0 && options.left_out_share <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("left-out share: expected within [0, 1], found ",
                     options.left_out_share));
  }
  if (options.threads < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "threads: expected 0 (all) or more, found ", options.threads));
  }
  for (const BlendedFiles& blend : options.blends) {
    SINEW_RETURN_IF_ERROR(CheckBlendOptions(blend.blend));
  }
  if (model.feet.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "character ", character, ": feet: expected at least one, found none"));
  }
  return absl::OkStatus();
}

// A credit of nothing is a path with an error in it.
absl::Status CheckCredits(const ImportOptions& options,
                          const std::vector<std::string>& files) {
  std::set<const PathCredit*> used;
  const auto use = [&](const std::string& file) {
    used.insert(NearestCredit(file, options.credits));
  };
  for (const std::string& file : files) use(file);
  for (const BlendedFiles& blend : options.blends) {
    use(blend.first);
    use(blend.second);
  }
  for (const PathCredit& credit : options.credits) {
    if (used.contains(&credit)) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "credit: expected the path of a file of this import or of a folder "
        "above one that no other credit is nearer to, found \"",
        credit.path, "\""));
  }
  return absl::OkStatus();
}

// Whether a clip of these files (of which one may be empty) is mirrored.
bool IsMirrored(const ImportOptions& options, const std::string& file,
                const std::string& next) {
  if (!options.edits.mirror || options.mirror_within.empty()) {
    return options.edits.mirror;
  }
  return std::any_of(options.mirror_within.begin(), options.mirror_within.end(),
                     [&](const std::string& path) {
                       return LiesWithin(file, path) || LiesWithin(next, path);
                     });
}

// A path that mirrors nothing is one with an error in it.
absl::Status CheckMirrors(const ImportOptions& options,
                          const std::vector<std::string>& files) {
  if (!options.edits.mirror && !options.mirror_within.empty()) {
    return absl::InvalidArgumentError(
        "mirror within: expected no paths, since clips are not mirrored, found "
        "some");
  }
  for (const std::string& path : options.mirror_within) {
    const auto within = [&](const std::string& file) {
      return LiesWithin(file, path);
    };
    if (std::any_of(files.begin(), files.end(), within) ||
        std::any_of(options.blends.begin(), options.blends.end(),
                    [&](const BlendedFiles& blend) {
                      return within(blend.first) || within(blend.second);
                    })) {
      continue;
    }
    return absl::InvalidArgumentError(
        absl::StrCat("mirror within: expected the path of a file of this "
                     "import or of a folder above one, found \"",
                     path, "\""));
  }
  return absl::OkStatus();
}

std::string Dump(const Json& json) {
  return json.dump(1, ' ', /*ensure_ascii=*/false,
                   Json::error_handler_t::replace);
}

// Tells whoever asked after every file, one at a time.
class Telling {
 public:
  Telling(const ImportOptions& options, int total)
      : options_(options), total_(total) {}

  void Done(const ClipReport& report) SINEW_EXCLUDES(mu_) {
    // What was interrupted is neither good nor bad.
    if (!options_.on_progress || absl::IsCancelled(report.status)) return;
    MutexLock lock(mu_);
    options_.on_progress({++done_, total_, &report});
  }

 private:
  const ImportOptions& options_;
  const int total_;
  Mutex mu_;
  int done_ SINEW_GUARDED_BY(mu_) = 0;
};

ClipReport Refused(const ImportContext& context, const ImportJob& job,
                   const absl::Status& status) {
  ClipReport report;
  report.file = job.Path();
  report.name = job.Name();
  report.status = status;
  Judge(context.options, &report);
  return report;
}

// The clip of a job if it has a name.
ClipReport RunNamed(const ImportContext& context, const ImportJob& job,
                    const absl::StatusOr<std::string>& name) {
  if (const absl::Status readable = job.readable(); !readable.ok()) {
    return Refused(context, job, readable);
  }
  if (!name.ok()) return Refused(context, job, name.status());
  ClipReport report = RunJob(context, job, *name);
  const std::string plain = job.Name();
  if (*name != plain && report.measured()) {
    report.warnings.push_back(absl::StrCat("another file is called ", plain,
                                           "; this clip is ", report.name));
  }
  return report;
}

// One job per file, then one per blend.
std::vector<ImportJob> MakeJobs(const ImportOptions& options,
                                const std::vector<std::string>& files,
                                int threads) {
  std::vector<ImportJob> jobs(files.size() + options.blends.size());
  ForEachIndex(
      static_cast<int>(jobs.size()), threads, options.stop, [&](size_t i) {
        jobs[i] = i < files.size()
                      ? MakeJob(files[i], options.read)
                      : MakeJob(options.blends[i - files.size()], options.read);
      });
  return jobs;
}

// One report per job and copy, in order.
std::vector<ClipReport> RunJobs(const ImportContext& context,
                                const std::vector<std::string>& files,
                                int threads) {
  const ImportOptions& options = context.options;
  const std::vector<ImportJob> jobs = MakeJobs(options, files, threads);
  std::vector<NamedFile> named;
  for (const ImportJob& job : jobs) {
    named.push_back(
        {job.file.path, job.Sha256(), job.next.has_value() ? job.Name() : ""});
  }
  const auto names = UniqueNames(named);

  std::set<std::string> taken;
  for (const auto& name : names) {
    if (name.ok()) taken.insert(*name);
  }
  struct Copy {
    size_t job;
    bool mirrored;
  };
  std::vector<Copy> copies;
  for (size_t i = 0; i < jobs.size(); ++i) {
    copies.push_back({i, false});
    const std::string next = jobs[i].next ? jobs[i].next->path : "";
    if (IsMirrored(options, jobs[i].file.path, next)) {
      copies.push_back({i, true});
    }
  }
  const auto count = static_cast<int>(copies.size());
  std::vector<ClipReport> reports(copies.size());
  Telling telling(options, count);
  ForEachIndex(count, threads, options.stop, [&](int i) {
    ImportJob job = jobs[copies[i].job];
    job.mirrored = copies[i].mirrored;
    absl::StatusOr<std::string> name = names[copies[i].job];
    if (job.mirrored && name.ok() &&
        taken.contains(absl::StrCat(*name, kMirrorSuffix))) {
      name = absl::AlreadyExistsError(
          absl::StrCat(job.Path(),
                       ": expected a unique name for its mirror "
                       "image, found a file called ",
                       *name, kMirrorSuffix));
    }
    reports[i] = RunNamed(context, job, name);
    telling.Done(reports[i]);
  });
  return reports;
}

// What the library and its report follow from, as a digest.
std::string OutcomeDigest(const std::string& options_sha256,
                          absl::Span<const ClipReport> reports) {
  Json clips = Json::array();
  for (const ClipReport& report : reports) {
    clips.push_back({report.file, report.name, report.cache_key,
                     StatusName(report.verdict.status), report.verdict.reason,
                     report.info.provenance(), report.info.licence(),
                     report.info.trial(), report.warnings});
    // Only where it holds: libraries of before are still what they were.
    if (report.info.left_out()) clips.back().push_back("left out");
  }
  return Sha256Hex(absl::StrCat(options_sha256, Dump(clips)));
}

// What a newer version wrote is not overwritten.
absl::Status CheckNotNewer(const std::string& directory) {
  const std::string path = JoinPath(directory, kManifestFile);
  const auto text = ReadFile(path, kMaxJsonBytes);
  if (absl::IsNotFound(text.status())) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(text.status());
  const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  const Json version =
      json.is_object() ? json.value("format_version", Json()) : Json();
  if (!version.is_number() ||
      version.get<double>() <= motion::kLibraryFormatVersion) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      path, ": format_version: expected at most ",
      motion::kLibraryFormatVersion, ", found ", version.dump(),
      " (written by a newer version); import into another folder"));
}

// True if the folder holds what import.json says that it was made to hold, of
// this outcome.
bool UpToDate(const std::string& directory, const std::string& outcome) {
  const auto text = ReadFile(JoinPath(directory, kImportFile), kMaxJsonBytes);
  const auto manifest =
      ReadFile(JoinPath(directory, kManifestFile), kMaxJsonBytes);
  if (!text.ok() || !manifest.ok() ||
      !FileExists(JoinPath(directory, kReportFile))) {
    return false;
  }
  const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || json.value("outcome", Json()) != Json(outcome) ||
      json.value("manifest_sha256", Json()) != Json(Sha256Hex(*manifest))) {
    return false;
  }
  // The manifest has the digest of the frames.
  const auto library = motion::Library::Load(directory);
  return library.ok() && (*library)->Verify().ok();
}

absl::Status WriteImportFile(const std::string& directory,
                             const std::string& outcome) {
  SINEW_ASSIGN_OR_RETURN(
      const std::string manifest,
      ReadFile(JoinPath(directory, kManifestFile), kMaxJsonBytes));
  const Json json = {{"importer_version", kImporterVersion},
                     {"outcome", outcome},
                     {"manifest_sha256", Sha256Hex(manifest)}};
  return WriteFileAtomically(JoinPath(directory, kImportFile), Dump(json));
}

absl::Status NothingImported(absl::Span<const ClipReport> reports) {
  std::string message = absl::StrCat(
      "expected at least one clip that can be imported, found none in ",
      reports.size(), " files");
  constexpr size_t kShown = 3;
  for (size_t i = 0; i < std::min(kShown, reports.size()); ++i) {
    absl::StrAppend(&message, i == 0 ? ": " : "; ", reports[i].file, ": ",
                    reports[i].status.message());
  }
  if (reports.size() > kShown) absl::StrAppend(&message, "; ...");
  return absl::InvalidArgumentError(message);
}

// Library, reports and cache of a finished round.
absl::Status WriteAll(const character::Character& character,
                      const ImportContext& context,
                      absl::Span<const ClipReport> reports,
                      const std::string& directory) {
  const std::string outcome = OutcomeDigest(context.options_sha256, reports);
  const bool same =
      !context.options.report_only && UpToDate(directory, outcome);
  if (context.options.changed != nullptr) *context.options.changed = !same;
  if (same) return absl::OkStatus();
  const bool any =
      std::any_of(reports.begin(), reports.end(),
                  [](const ClipReport& report) { return report.status.ok(); });
  const bool has_library = FileExists(JoinPath(directory, kManifestFile));
  if (has_library && context.options.report_only) {
    return absl::FailedPreconditionError(absl::StrCat(
        directory,
        ": expected a folder without a library for a report alone, "
        "found one"));
  }
  // A library that is there keeps its own report.
  if (has_library && !any) return NothingImported(reports);
  // No longer what the folder holds, until all is written.
  SINEW_RETURN_IF_ERROR(RemoveRecursively(JoinPath(directory, kImportFile)));
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(
      JoinPath(directory, kReportFile),
      Dump(ReportJson(reports, character.name(), context.options.rate))));
  if (!any) return NothingImported(reports);
  if (context.options.report_only) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(WriteLibrary(character, context.model,
                                     context.options.rate, reports,
                                     context.cache, directory));
  SINEW_RETURN_IF_ERROR(WriteImportFile(directory, outcome));
  std::set<std::string> keys;
  for (const ClipReport& report : reports) keys.insert(report.cache_key);
  return context.cache.KeepOnly(keys);
}

}  // namespace

absl::Status ImportFiles(const character::Character& character,
                         const std::vector<std::string>& files,
                         const ImportOptions& options,
                         const std::string& directory,
                         std::vector<ClipReport>* reports) {
  const ImportModel model = MakeImportModel(character);
  SINEW_RETURN_IF_ERROR(Check(options, model, character.name()));
  SINEW_RETURN_IF_ERROR(CheckCredits(options, files));
  SINEW_RETURN_IF_ERROR(CheckMirrors(options, files));
  SINEW_RETURN_IF_ERROR(MakeDirectories(directory));
  SINEW_ASSIGN_OR_RETURN(const auto lock, DirectoryLock::Acquire(directory));
  SINEW_RETURN_IF_ERROR(CheckNotNewer(directory));
  const ClipCache cache(JoinPath(directory, kCacheFolder));
  MotionMirror mirror;
  if (options.edits.mirror) {
    SINEW_ASSIGN_OR_RETURN(mirror, MakeMotionMirror(character));
  }
  const ImportContext context{model, options,
                              OptionsDigest(character.digest(), options), cache,
                              mirror};
  const int threads = options.threads > 0 ? options.threads : AvailableCpus();
  *reports = RunJobs(context, files, threads);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("import: stopped before its end");
  }
  return WriteAll(character, context, *reports, directory);
}

}  // namespace sinew::import
