#ifndef SINEW_SIM_CHARACTER_CHARACTER_PATH_H_
#define SINEW_SIM_CHARACTER_CHARACTER_PATH_H_

#include <string>

#include "absl/status/statusor.h"

namespace sinew::character {

// The path of a character.textproto. What has a slash or ends in ".textproto"
// is taken as a path; any other is looked for as NAME/character.textproto in,
// in this order: the folders of $SINEW_CHARACTERS (colon-separated), the
// binary's runfiles, the tests' runfiles, the source tree the binary was built
// in (found above the working directory). NOT_FOUND lists where was looked;
// INVALID_ARGUMENT: the path is a folder's.
absl::StatusOr<std::string> FindCharacter(const std::string& name_or_path);

// The MJCF that a character names, one of
//   PATH                relative to its text proto;
//   @REPOSITORY//PATH   a file that the build fetches: REPOSITORY/PATH beside
//                       the text proto (as in bundles), in the folders of
//                       $SINEW_CHARACTERS and in the runfiles;
//   $VARIABLE/PATH      a file that the user has: VARIABLE/PATH beside the text
//                       proto (as in bundles), then PATH in the folder that the
//                       environment variable names, e.g.
//                       "$SINEW_DATA/models/h1.xml".
// NOT_FOUND lists where was looked, and names a variable that is unset.
absl::StatusOr<std::string> FindModelFile(const std::string& character_path,
                                          const std::string& model_file);

// Where such a file lies beside the text proto in a folder that holds both:
// PATH, REPOSITORY/PATH or VARIABLE/PATH.
std::string LocalModelFile(const std::string& model_file);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_CHARACTER_PATH_H_
