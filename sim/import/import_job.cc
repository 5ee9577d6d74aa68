#include "sim/import/import_job.h"

#include <mujoco/mujoco.h>

#include <initializer_list>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "sim/import/clip_name.h"
#include "sim/import/credit.h"
#include "sim/import/detect_format.h"
#include "sim/import/import_clip.h"
#include "sim/import/retarget/retarget.h"
#include "sim/motion/split.h"

namespace sinew::import {
namespace {

// A field of a text whose parts cannot run into each other.
void AddField(absl::string_view name, absl::string_view value,
              std::string* text) {
  absl::StrAppend(text, name, ":", value.size(), ":", value, "\n");
}

// Each number by a text of its own.
std::string Exact(std::initializer_list<double> numbers) {
  return absl::StrJoin(numbers, " ", [](std::string* text, double number) {
    absl::StrAppendFormat(text, "%.17g", number);
  });
}

void AddFile(const JobFile& file, std::string* text) {
  AddField("content", file.sha256, text);
  AddField("companions", file.companions_sha256, text);
  // Formats without a signature are told apart by the extension.
  AddField("kind", LowerCaseExtension(file.path), text);
}

// What a clip is made of.
void AddContent(const ImportJob& job, std::string* text) {
  AddFile(job.file, text);
  if (!job.next.has_value()) return;
  AddFile(*job.next, text);
  const BlendOptions& blend = job.blend;
  AddField("blend",
           Exact({blend.gap_s, blend.first.from_s, blend.first.to_s,
                  blend.second.from_s, blend.second.to_s}),
           text);
}

std::string Key(const ImportContext& context, const ImportJob& job) {
  std::string text;
  AddField("options", context.options_sha256, &text);
  AddContent(job, &text);
  AddField("mirrored", job.mirrored ? "yes" : "no", &text);
  return Sha256Hex(text);
}

// Of the files that are read with it; empty where they are not to be found,
// which reading will say.
std::string CompanionsDigest(const std::string& file, absl::string_view bytes,
                             const ReadClipOptions& options) {
  const auto companions = CompanionFiles(file, bytes, options);
  if (!companions.ok()) return "";
  std::string digests;
  for (const std::string& companion : *companions) {
    const auto content = ReadFile(companion, kMaxClipBytes);
    absl::StrAppend(&digests, content.ok() ? Sha256Hex(*content) : "none");
  }
  return Sha256Hex(digests);
}

JobFile ReadJobFile(const std::string& path, const ReadClipOptions& options) {
  JobFile file;
  file.path = path;
  const absl::StatusOr<std::string> bytes = ReadFile(path, kMaxClipBytes);
  if (!bytes.ok()) {
    file.readable = bytes.status();
    return file;
  }
  file.sha256 = Sha256Hex(*bytes);
  file.companions_sha256 = CompanionsDigest(path, *bytes, options);
  return file;
}

// The clip of a file, if that is still what it was.
absl::StatusOr<Source> Read(const ImportContext& context, const JobFile& file,
                            const std::string& name) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadFile(file.path, kMaxClipBytes));
  if (Sha256Hex(bytes) != file.sha256) {
    return absl::AbortedError(
        absl::StrCat(file.path, ": it changed while it was being imported"));
  }
  absl::StatusOr<Source> source =
      ReadClip(file.path, bytes, name, &context.model, context.options.read);
  if (CompanionsDigest(file.path, bytes, context.options.read) !=
      file.companions_sha256) {
    return absl::AbortedError(absl::StrCat(
        file.path, ": its skeleton changed while it was being imported"));
  }
  return source;
}

absl::StatusOr<ImportedClip> Import(const ImportContext& context,
                                    const ImportJob& job,
                                    const std::string& name) {
  ClipOptions options;
  options.rate = context.options.rate;
  if (context.options.map) options.map = &*context.options.map;
  options.edits = context.options.edits;
  options.edits.mirror = job.mirrored;
  options.mirror = &context.mirror;
  options.stop = context.options.stop;
  if (!job.next.has_value()) {
    SINEW_ASSIGN_OR_RETURN(const Source source, Read(context, job.file, name));
    return ImportClip(context.model, source, options);
  }
  SINEW_ASSIGN_OR_RETURN(const Source first,
                         Read(context, job.file, ClipName(job.file.path)));
  SINEW_ASSIGN_OR_RETURN(const Source second,
                         Read(context, *job.next, ClipName(job.next->path)));
  return ImportBlend(context.model, first, second, job.blend, options);
}

// Errors of a clip name it, but not always its file.
absl::Status WithFile(const ImportJob& job, const absl::Status& status) {
  if (absl::StrContains(status.message(), job.file.path) ||
      (job.next && absl::StrContains(status.message(), job.next->path))) {
    return status;
  }
  return absl::Status(status.code(),
                      absl::StrCat(job.Path(), ": ", status.message()));
}

// What a manifest calls a file: without folders.
std::string SourceFile(const std::string& path) {
  const std::string extension = LowerCaseExtension(path);
  return absl::StrCat(ClipName(path),
                      path.substr(path.size() - extension.size()));
}

Credit CreditIn(const ImportOptions& options, const JobFile& file) {
  return CreditOf(file.path, options.credits, options.credit);
}

// What the cache holds does not know the clip's file and library.
void Dress(const ImportContext& context, const ImportJob& job,
           const std::string& name, ClipReport* report) {
  report->file = job.Path();
  report->name = job.mirrored ? absl::StrCat(name, kMirrorSuffix) : name;
  if (!report->measured()) return;
  v1::ClipInfo& info = report->info;
  info.set_name(report->name);
  info.set_mirror_of(job.mirrored ? name : "");
  info.set_source_file(SourceFile(job.file.path));
  info.set_source_sha256(job.file.sha256);
  info.set_trial(TrialName(job.file.path));
  if (job.next.has_value()) {
    v1::BlendedClip& next = *info.mutable_blend();
    next.set_source_file(SourceFile(job.next->path));
    next.set_source_sha256(job.next->sha256);
    next.set_trial(TrialName(job.next->path));
  }
  info.set_left_out(motion::IsLeftOut(info, context.options.left_out_share));
  Credit credit = CreditIn(context.options, job.file);
  if (job.next.has_value()) {
    credit = Joined(credit, CreditIn(context.options, *job.next));
  }
  info.set_provenance(credit.provenance);
  info.set_licence(credit.licence);
}

ClipReport RunFresh(const ImportContext& context, const ImportJob& job,
                    const std::string& key, const std::string& name) {
  ClipReport report;
  report.file = job.Path();
  const double start = ThreadSeconds();
  absl::StatusOr<ImportedClip> clip = Import(context, job, name);
  report.core_seconds = ThreadSeconds() - start;
  if (!clip.ok()) {
    report.status = WithFile(job, clip.status());
    // What may be different the next time is not kept.
    if (absl::IsInvalidArgument(report.status) &&
        context.cache.StoreError(key, report).ok()) {
      report.cache_key = key;
    }
    return report;
  }
  report.info = clip->info;
  report.duration_s = clip->duration_s;
  report.retiming = clip->retiming;
  report.supported_share = clip->supported_share;
  report.warnings = clip->warnings;
  report.cache_key = key;
  report.status = context.cache.Store(key, report, *clip);
  return report;
}

}  // namespace

void Judge(const ImportOptions& options, ClipReport* report) {
  if (!report->status.ok()) {
    report->verdict.status = ClipStatus::kRejected;
    report->verdict.reason = std::string(report->status.message());
    return;
  }
  report->verdict = JudgeQuality(report->info.quality());
  Verdict& verdict = report->verdict;
  const v1::ClipInfo& info = report->info;
  if (!options.map && verdict.status == ClipStatus::kOk &&
      (info.source().map() == kDraftName ||
       info.blend().source().map() == kDraftName)) {
    verdict.status = ClipStatus::kWarned;
    verdict.reason =
        "no known skeleton map fits; one was drafted from joint names and "
        "rest pose";
  }
  const std::string too_short = TooShort(info, report->duration_s);
  if (!too_short.empty()) {
    verdict.status = ClipStatus::kRejected;
    verdict.reason = too_short;
    verdict.findings.insert(verdict.findings.begin(), too_short);
  }
  if (verdict.status == ClipStatus::kRejected) {
    report->status = absl::FailedPreconditionError(
        absl::StrCat(report->file, ": ", verdict.reason));
  }
}

absl::Status ImportJob::readable() const {
  if (!file.readable.ok() || !next.has_value()) return file.readable;
  return next->readable;
}

std::string ImportJob::Path() const {
  if (!next.has_value()) return file.path;
  return absl::StrCat(file.path, " + ", next->path);
}

std::string ImportJob::Name() const {
  if (!name.empty()) return name;
  return next.has_value() ? BlendName(file.path, next->path)
                          : ClipName(file.path);
}

std::string ImportJob::Sha256() const {
  if (!readable().ok()) return "";
  if (!next.has_value()) return file.sha256;
  std::string text;
  AddContent(*this, &text);
  return Sha256Hex(text);
}

ImportJob MakeJob(const std::string& file, const ReadClipOptions& options) {
  ImportJob job;
  job.file = ReadJobFile(file, options);
  return job;
}

ImportJob MakeJob(const BlendedFiles& files, const ReadClipOptions& options) {
  ImportJob job = MakeJob(files.first, options);
  job.next = ReadJobFile(files.second, options);
  job.blend = files.blend;
  job.name = files.name;
  return job;
}

std::string OptionsDigest(const std::string& character_digest,
                          const ImportOptions& options) {
  const ReadOptions& read = options.read.read;
  const auto number = [](const std::optional<double>& value) {
    return value ? Exact({*value}) : std::string("unset");
  };
  std::string text;
  AddField("importer", absl::StrCat(kImporterVersion), &text);
  AddField("mujoco", absl::StrCat(mj_version()), &text);
  AddField("character", character_digest, &text);
  AddField("rate", Exact({options.rate}), &text);
  AddField("format", options.read.format, &text);
  AddField("unit", number(read.metres_per_unit), &text);
  AddField("up", read.up_axis ? std::string(1, *read.up_axis) : "", &text);
  AddField("fps", number(read.frames_per_second), &text);
  AddField("order", read.quaternion_order.value_or(""), &text);
  const EditOptions& edits = options.edits;
  AddField("edits",
           absl::StrCat(
               Exact({edits.from_s, edits.to_s}), " ", edits.loop, " ",
               Exact({edits.loop_options.least_s, edits.loop_options.most_s}),
               " ", edits.align_heading),
           &text);
  AddField("map", options.map ? SerializeDeterministically(*options.map) : "",
           &text);
  return Sha256Hex(text);
}

ClipReport RunJob(const ImportContext& context, const ImportJob& job,
                  const std::string& name) {
  const std::string key = Key(context, job);
  absl::StatusOr<ClipReport> found = context.cache.FindReport(key);
  // An error names the file as it was called then.
  const bool usable =
      found.ok() && (found->status.ok() || found->file == job.Path());
  ClipReport report =
      usable ? *std::move(found) : RunFresh(context, job, key, name);
  Dress(context, job, name, &report);
  Judge(context.options, &report);
  return report;
}

}  // namespace sinew::import
