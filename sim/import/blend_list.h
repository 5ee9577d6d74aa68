#ifndef SINEW_SIM_IMPORT_BLEND_LIST_H_
#define SINEW_SIM_IMPORT_BLEND_LIST_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/blend_clips.h"

namespace sinew::import {

// Two files whose clips are joined over a gap into one of the library.
struct BlendedFiles {
  std::string first, second;  // paths
  BlendOptions blend = {};
  // What the clip is called; empty: BlendName. If another clip of the library
  // has that name, see UniqueNames (clip_name.h).
  std::string name = {};
};

// FIRST_to_SECOND after the files. Pure.
std::string BlendName(absl::string_view first, absl::string_view second);

// Reads a v1::BlendList in text format, 1 MiB at most. Relative paths begin at
// `root`, or, if that is empty, at the list's folder; whether such files are
// there is not looked at.
//
// Thread-safety: any thread. Blocking: reads a file. Errors: those of reading;
// INVALID_ARGUMENT naming the list, the pair (from 1), its field, expected and
// found: syntax, no pairs, a path or number that is missing or out of range, a
// name that is none or another pair's; a root that is no folder.
absl::StatusOr<std::vector<BlendedFiles>> ReadBlendList(
    const std::string& path, const std::string& root);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_BLEND_LIST_H_
