#ifndef SINEW_SIM_IMPORT_IMPORT_JOB_H_
#define SINEW_SIM_IMPORT_IMPORT_JOB_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "sim/import/blend_clips.h"
#include "sim/import/clip_cache.h"
#include "sim/import/clip_report.h"
#include "sim/import/importer.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

// A file as it was when the import began.
struct JobFile {
  std::string path;
  absl::Status readable;  // OK, or why it could not be read
  std::string sha256;     // of the content; of the companions, in one
  std::string companions_sha256;
};

// One clip on its way into a library.
struct ImportJob {
  JobFile file;
  // What follows it over a gap, and how, of a clip that is joined from two.
  std::optional<JobFile> next;
  BlendOptions blend;
  std::string name;  // given; empty: after the files
  // The mirror image of the clip is meant.
  bool mirrored = false;

  // OK, or why one of its files could not be read.
  absl::Status readable() const;
  // What reports call its source: the file's path, or "FIRST + SECOND".
  std::string Path() const;
  // What it would like to be called, without kMirrorSuffix.
  std::string Name() const;
  // Of the content that it is made of; empty: it could not be read.
  std::string Sha256() const;
};

// Read the files once to know them by their content. Blocking: on the disk.
ImportJob MakeJob(const std::string& file, const ReadClipOptions& options);
ImportJob MakeJob(const BlendedFiles& files, const ReadClipOptions& options);

// What all files of an import share. Borrows everything.
struct ImportContext {
  const ImportModel& model;
  const ImportOptions& options;
  // SHA-256 of character, options and versions: what besides a file's content
  // its result depends on.
  std::string options_sha256;
  const ClipCache& cache;
  // Of the character; empty unless options.edits.mirror.
  const MotionMirror& mirror;
};

// What a clip's mirror image is called: NAME_mirror.
inline constexpr char kMirrorSuffix[] = "_mirror";

// Fills a report's verdict from its figures or, if it is not OK, its status; a
// clip that the quality gate rejects gets FAILED_PRECONDITION. A map that the
// import drafted itself is worth a warning. Pure.
void Judge(const ImportOptions& options, ClipReport* report);

// The digest for ImportContext.
std::string OptionsDigest(const std::string& character_digest,
                          const ImportOptions& options);

// Takes the clip from the cache or imports it and puts it there. Never fails:
// what goes wrong is the report's status (also if the cache cannot be written).
// `name` is the clip's (without kMirrorSuffix); the report's info is complete
// but for first_frame.
//
// Thread-safety: yes. Blocking: on the disk; seconds of computation.
ClipReport RunJob(const ImportContext& context, const ImportJob& job,
                  const std::string& name);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_IMPORT_JOB_H_
