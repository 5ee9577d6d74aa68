#include "sim/import/import_job.h"

#include <mujoco/mujoco.h>

#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "sim/import/clip_name.h"
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

std::string Key(const ImportContext& context, const ImportJob& job) {
  std::string text;
  AddField("options", context.options_sha256, &text);
  AddField("content", job.sha256, &text);
  AddField("companions", job.companions_sha256, &text);
  AddField("mirrored", job.mirrored ? "yes" : "no", &text);
  // Formats without a signature are told apart by the extension.
  AddField("kind", LowerCaseExtension(job.file), &text);
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

absl::StatusOr<ImportedClip> Import(const ImportContext& context,
                                    const ImportJob& job,
                                    const std::string& name) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadFile(job.file, kMaxClipBytes));
  if (Sha256Hex(bytes) != job.sha256) {
    return absl::AbortedError(
        absl::StrCat(job.file, ": it changed while it was being imported"));
  }
  const absl::StatusOr<Source> source =
      ReadClip(job.file, bytes, name, &context.model, context.options.read);
  if (CompanionsDigest(job.file, bytes, context.options.read) !=
      job.companions_sha256) {
    return absl::AbortedError(absl::StrCat(
        job.file, ": its skeleton changed while it was being imported"));
  }
  SINEW_RETURN_IF_ERROR(source.status());
  ClipOptions options;
  options.rate = context.options.rate;
  if (context.options.map) options.map = &*context.options.map;
  options.edits = context.options.edits;
  options.edits.mirror = job.mirrored;
  options.mirror = &context.mirror;
  return ImportClip(context.model, *source, options);
}

// Errors of a clip name it, but not always its file.
absl::Status WithFile(const std::string& file, const absl::Status& status) {
  if (absl::string_view(status.message()).find(file) !=
      absl::string_view::npos) {
    return status;
  }
  return absl::Status(status.code(),
                      absl::StrCat(file, ": ", status.message()));
}

// What the cache holds does not know the clip's file and library.
void Dress(const ImportContext& context, const ImportJob& job,
           const std::string& name, ClipReport* report) {
  report->file = job.file;
  report->name = job.mirrored ? absl::StrCat(name, kMirrorSuffix) : name;
  if (!report->measured()) return;
  v1::ClipInfo& info = report->info;
  info.set_name(report->name);
  info.set_mirror_of(job.mirrored ? name : "");
  const std::string stem = ClipName(job.file);
  info.set_source_file(absl::StrCat(
      stem,
      job.file.substr(job.file.size() - LowerCaseExtension(job.file).size())));
  info.set_source_sha256(job.sha256);
  info.set_trial(TrialName(job.file));
  info.set_left_out(motion::IsLeftOut(motion::SplitKey(info),
                                      context.options.left_out_share));
  info.set_provenance(context.options.provenance);
  info.set_licence(context.options.licence);
}

ClipReport RunFresh(const ImportContext& context, const ImportJob& job,
                    const std::string& key, const std::string& name) {
  ClipReport report;
  report.file = job.file;
  const double start = ThreadSeconds();
  absl::StatusOr<ImportedClip> clip = Import(context, job, name);
  report.core_seconds = ThreadSeconds() - start;
  if (!clip.ok()) {
    report.status = WithFile(job.file, clip.status());
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
  if (!options.map && verdict.status == ClipStatus::kOk &&
      report->info.source().map() == kDraftName) {
    verdict.status = ClipStatus::kWarned;
    verdict.reason =
        "no known skeleton map fits; one was drafted from joint names and "
        "rest pose";
  }
  if (report->verdict.status == ClipStatus::kRejected) {
    report->status = absl::FailedPreconditionError(
        absl::StrCat(report->file, ": ", report->verdict.reason));
  }
}

ImportJob MakeJob(const std::string& file, const ReadClipOptions& options) {
  ImportJob job;
  job.file = file;
  const absl::StatusOr<std::string> bytes = ReadFile(file, kMaxClipBytes);
  if (!bytes.ok()) {
    job.readable = bytes.status();
    return job;
  }
  job.sha256 = Sha256Hex(*bytes);
  job.companions_sha256 = CompanionsDigest(file, *bytes, options);
  return job;
}

std::string OptionsDigest(const std::string& character_digest,
                          const ImportOptions& options) {
  const ReadOptions& read = options.read.read;
  const auto exact = [](double value) {
    return absl::StrFormat("%.17g", value);
  };
  const auto number = [&](const std::optional<double>& value) {
    return value ? exact(*value) : std::string("unset");
  };
  std::string text;
  AddField("importer", absl::StrCat(kImporterVersion), &text);
  AddField("mujoco", absl::StrCat(mj_version()), &text);
  AddField("character", character_digest, &text);
  AddField("rate", exact(options.rate), &text);
  AddField("format", options.read.format, &text);
  AddField("unit", number(read.metres_per_unit), &text);
  AddField("up", read.up_axis ? std::string(1, *read.up_axis) : "", &text);
  AddField("fps", number(read.frames_per_second), &text);
  AddField("order", read.quaternion_order.value_or(""), &text);
  const EditOptions& edits = options.edits;
  AddField(
      "edits",
      absl::StrCat(exact(edits.from_s), " ", exact(edits.to_s), " ", edits.loop,
                   " ", exact(edits.loop_options.least_s), " ",
                   exact(edits.loop_options.most_s), " ", edits.align_heading),
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
      found.ok() && (found->status.ok() || found->file == job.file);
  ClipReport report =
      usable ? *std::move(found) : RunFresh(context, job, key, name);
  Dress(context, job, name, &report);
  Judge(context.options, &report);
  return report;
}

}  // namespace sinew::import
