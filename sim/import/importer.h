#ifndef SINEW_SIM_IMPORT_IMPORTER_H_
#define SINEW_SIM_IMPORT_IMPORTER_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/stop.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/character/character.h"
#include "sim/import/blend_list.h"
#include "sim/import/clip_report.h"
#include "sim/import/credit.h"
#include "sim/import/edit.h"
#include "sim/import/read_clip.h"

namespace sinew::import {

// Bumped with every change of readers, maps, retargeting or figures that
// changes results: entries of other versions are not taken from the cache.
inline constexpr int kImporterVersion = 8;

// How far an import is.
struct ImportProgress {
  int done = 0;  // files and blends, their mirror images as well
  int total = 0;
  const ClipReport* last = nullptr;  // what was just finished
};

struct ImportOptions {
  // Frames per second of the library, > 0 and at most 1000; must equal the
  // control rate of the recipes that will use it.
  double rate = 30;
  // Of files that lie within none of `credits`.
  Credit credit = {};
  // Of the others; each must be the credit of a file of the import.
  std::vector<PathCredit> credits = {};
  // How files are read; the same for all of them.
  ReadClipOptions read = {};
  // Roles of the source's joints; unset: found or drafted for each file.
  std::optional<v1::SkeletonMap> map = {};
  // What to do with every clip once it is on the character. `mirror` adds the
  // mirror image of each as a clip of its own, NAME_mirror.
  EditOptions edits = {};
  // With edits.mirror: of the clips of files within these paths alone
  // (credit.h), of a blend where one of its files is; each path must have a
  // file of the import. Empty: of all.
  std::vector<std::string> mirror_within = {};
  // Clips that are made of two files each; those files are clips of their own
  // only if they are among the files as well.
  std::vector<BlendedFiles> blends = {};
  // Share of the recordings that is left out of training, [0, 1]
  // (sim/motion/split.h).
  double left_out_share = 0;
  // Measure and report, but leave the library as it is.
  bool report_only = false;
  // Threads; 0: all processors that this process may use.
  int threads = 0;
  // Called after every file, by one thread at a time.
  std::function<void(const ImportProgress&)> on_progress = {};
  StopToken stop = {};
  // Set to whether anything was written, if not null.
  bool* changed = nullptr;
};

// Reads files of any format, fits each to the character, holds the figures
// against the quality gate and writes a library of what passed:
//
//   LIB/manifest.json, LIB/frames.safetensors   the library; replaced together
//   LIB/report.json                             clip_report.h
//   LIB/cache/                                  clip_cache.h
//   LIB/import.json                             what the library was made of
//
// A bad file never stops the others: `reports` gets one entry per file, then
// one per blend (two where it is mirrored), in order, also when the call fails.
// Names and what becomes of a second file of a name: clip_name.h. Results do
// not depend on the number of threads. Files that an earlier import with the
// same options has seen are not read again but for their digest; if nothing at
// all changed, nothing is written.
//
// Thread-safety: one import per folder at a time (DirectoryLock). Ownership:
// borrows everything for the call. Memory: one clip per thread, then the
// library's frames. Blocking: on the disk, and seconds of a core per clip.
// Errors: INVALID_ARGUMENT if options are out of range, a credit or a
// path of mirror_within is of none of the files, the character has no feet, or
// no file could be imported (the report is written, the library stays what it
// was); CANCELLED (what was finished is kept for the next time);
// FAILED_PRECONDITION if another import holds the folder, or a newer version
// wrote the library in it; DATA_LOSS if a cached clip was altered (the next
// import makes it anew); those of the disk.
absl::Status ImportFiles(const character::Character& character,
                         const std::vector<std::string>& files,
                         const ImportOptions& options,
                         const std::string& directory,
                         std::vector<ClipReport>* reports);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_IMPORTER_H_
