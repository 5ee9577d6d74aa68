#ifndef SINEW_SIM_IMPORT_MAPS_SKELETON_MAPS_H_
#define SINEW_SIM_IMPORT_MAPS_SKELETON_MAPS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Skeleton maps: which joint of a dialect's skeleton is what. Those that come
// with the project lie in sim/import/maps/skeletons, one file each, and are
// found like characters (common/workspace_files.h).
//
// Thread-safety: any thread. Blocking: LoadSkeletonMap and KnownSkeletonMaps
// read files. Errors: below.

// All roles that a joint may have, parents before children.
const std::vector<std::string>& AllRoles();
// Those that every map must give: root, hips, knees, ankles.
const std::vector<std::string>& RequiredRoles();

// Reads a v1::SkeletonMap in text format. INVALID_ARGUMENT naming `source`,
// field, expected and found: syntax, a name other than [a-z0-9_]+, an unknown
// role, a role or a joint twice, a required role missing, rest_degrees other
// than none or three finite numbers.
absl::StatusOr<v1::SkeletonMap> ParseSkeletonMap(absl::string_view text,
                                                 absl::string_view source);

// By name, or by path of a text proto (anything with a slash or a dot).
absl::StatusOr<v1::SkeletonMap> LoadSkeletonMap(
    const std::string& name_or_path);

// The maps that come with the project, by name. NOT_FOUND: the program lies
// where its files do not (lists where was looked).
absl::StatusOr<std::vector<v1::SkeletonMap>> KnownSkeletonMaps();

// Index of the joint that a map calls `name`: spelt so or, where no joint is,
// so after a prefix that ends in ":" or is "mixamorig"; -1: none.
int FindMapped(const SourceSkeleton& skeleton, absl::string_view name);

// Whether the map is good (ParseSkeletonMap) and all its joints are there and
// lie below one another as their roles do. INVALID_ARGUMENT naming map, joint,
// and the joints whose names are nearest.
absl::Status CheckMapFits(const v1::SkeletonMap& map,
                          const SourceSkeleton& skeleton);

// Of the maps that fit the one with most joints; null: none fits.
const v1::SkeletonMap* FindMapFor(const std::vector<v1::SkeletonMap>& maps,
                                  const SourceSkeleton& skeleton);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_MAPS_SKELETON_MAPS_H_
