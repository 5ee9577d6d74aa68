#ifndef SINEW_SIM_IMPORT_IMPORTER_H_
#define SINEW_SIM_IMPORT_IMPORTER_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/character/character.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

struct ImportOptions {
  // Frames per second of the library, > 0; must equal the control rate of the
  // recipes that will use it.
  double rate = 30;
  // Origin and licence of the data; copied into the library.
  std::string provenance;
  std::string licence;
};

// What became of one file.
struct ClipReport {
  std::string file;
  std::string name;
  // Why the file was left out; OK if it is in the library.
  absl::Status status;
  // Of an imported clip: its entry in the manifest.
  v1::ClipInfo info;
  double duration_s = 0;  // in the source
  // Speed against the source, from rounding to whole frames.
  double retiming = 1;
  // Largest joint rotation that closing the loop spread over the clip, rad.
  double seam_max_rad = 0;
  // Frames that the floor carries, share of all.
  double supported_share = 0;
  // Things worth a look, one sentence each.
  std::vector<std::string> warnings;
};

// A clip on a character, ready for a library.
struct ImportedClip {
  TensorMap frames;
  ClipReport report;  // file and source digest unset
};

// Plays a source clip on a character: joint fit, ground, dynamics, quality.
// Pure. INVALID_ARGUMENT naming the clip if it does not fit the character.
absl::StatusOr<ImportedClip> ImportClip(const ImportModel& model,
                                        const SourceClip& clip,
                                        const ImportOptions& options);

// Reads the files (DeepMimic JSON), imports each and writes the library folder.
// A bad file never stops the others: `reports` gets one entry per file, in
// order, also when the call fails. Names are file names without folder and
// extension; the second file of a name is refused.
//
// Blocking: on the disk, and seconds per clip. Errors: INVALID_ARGUMENT if
// options are out of range or no file could be imported (nothing is written
// then), and those of Library::Save.
absl::Status ImportFiles(const character::Character& character,
                         const std::vector<std::string>& files,
                         const ImportOptions& options,
                         const std::string& directory,
                         std::vector<ClipReport>* reports);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_IMPORTER_H_
