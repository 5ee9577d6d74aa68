#ifndef SINEW_SIM_IMPORT_FORMATS_BODY_SIZE_H_
#define SINEW_SIM_IMPORT_FORMATS_BODY_SIZE_H_

#include <optional>

#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// What the shape of a skeleton tells of a file's unit and up axis; FileFrame
// says how. The clip is in the file's own axes and units.
//
// Thread-safety: pure functions. Blocking: never. Errors: none; a skeleton
// without size or feet gives the defaults (1 m, y).

struct ConcludedUnit {
  double metres_per_unit = 1;
  // False: no usual unit gives a person's size.
  bool is_usual = true;
};

// `usual`: a unit to be preferred if it gives a person's size.
ConcludedUnit ConcludeUnit(const SourceSkeleton& skeleton,
                           std::optional<double> usual);

// 'y' or 'z'.
char ConcludeUpAxis(const SourceClip& clip);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_BODY_SIZE_H_
