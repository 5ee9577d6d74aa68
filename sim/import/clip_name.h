#ifndef SINEW_SIM_IMPORT_CLIP_NAME_H_
#define SINEW_SIM_IMPORT_CLIP_NAME_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// Names of clips and recordings, from the paths of their files. Pure.

// File name without folders and extension, as valid UTF-8 (bytes that are none
// become "%XX").
std::string ClipName(absl::string_view path);

// The recording that a file is of, the same for every format, trim and mirror
// image of it (v1::ClipInfo.trial):
//   CMU: "cmu/02_04" wherever subject and trial stand in a file name (02_04,
//     scaled_131_01, CMU-CMU-02-02_04_poses) and the name is nothing else, the
//     folders say "cmu", or the folder is the subject's;
//   others: the clip's name without suffixes that mirroring and conversion add
//     (_mirror, _mirrored, _poses, _stageii, _retargeted) and without a testbed
//     before a video (ASAP's TairanTestbed_CR7_video_CR7 is video_cr7), in
//     lower case. One name in two formats, as of a clip and its retargeted
//     copy, is one recording.
std::string TrialName(absl::string_view path);

// What is asked of one file's name.
struct NamedFile {
  std::string path;
  std::string sha256;  // of its content; empty: it could not be read
  // What it is called instead of the file's name; empty: as the file. A name
  // that is given twice is not the same clip because the file is.
  std::string name = {};
};

// A unique name for each file, in order. The first file of a name has it. A
// second one of other content is named after its folder or, from the same
// folder, its extension as well: "b/walk.bvh" after "a/walk.bvh" is "b_walk".
// ALREADY_EXISTS, naming both files, for the same file or the same content
// under the same name, and if the longer name is taken too.
std::vector<absl::StatusOr<std::string>> UniqueNames(
    const std::vector<NamedFile>& files);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_CLIP_NAME_H_
