#ifndef SINEW_SIM_IMPORT_MAPS_DRAFT_MAP_H_
#define SINEW_SIM_IMPORT_MAPS_DRAFT_MAP_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// A first map for a skeleton that no known map fits, for the user to look at
// and edit:
//   side of a joint: by its name (left, right, l, r as a word, or before one
//     that names a part of a limb), below a joint of a side the same;
//   arm or leg: by words of its name, else by where it hangs;
//   hip, knee, ankle and shoulder, elbow, wrist: ends of the two longest bones
//     that follow one another along the limb;
//   chest: where the arms meet; spine, neck and head: along the trunk.
// INVALID_ARGUMENT saying which of the required roles nothing was found for.
absl::StatusOr<v1::SkeletonMap> DraftSkeletonMap(const SourceSkeleton& skeleton,
                                                 absl::string_view name);

// Text format, one joint a line, as the files in this folder.
std::string SkeletonMapText(const v1::SkeletonMap& map);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_MAPS_DRAFT_MAP_H_
