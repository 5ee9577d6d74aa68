#ifndef SINEW_SIM_IMPORT_LIBRARY_WRITER_H_
#define SINEW_SIM_IMPORT_LIBRARY_WRITER_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "sim/character/character.h"
#include "sim/import/clip_cache.h"
#include "sim/import/clip_report.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import {

// Writes the library of all clips whose report is OK, in order, taking their
// frames from the cache. Blocking: on the disk. Errors: DATA_LOSS (a cache
// entry was altered), those of motion::Library::Save.
absl::Status WriteLibrary(const character::Character& character,
                          const ImportModel& model, double rate,
                          absl::Span<const ClipReport> reports,
                          const ClipCache& cache, const std::string& directory);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_LIBRARY_WRITER_H_
