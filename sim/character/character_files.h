#ifndef SINEW_SIM_CHARACTER_CHARACTER_FILES_H_
#define SINEW_SIM_CHARACTER_CHARACTER_FILES_H_

#include <map>
#include <string>

#include "absl/status/statusor.h"

namespace sinew::character {

// The files that Character::Load needs, by path relative to a folder of their
// own: "character.textproto" as it is, its MJCF and what that names (meshes,
// included files). Meshes and textures that are only seen are left out, with
// the geoms that show them, unless the MJCF includes others; the character
// that loads from the result is the same to physics (equal digest; checked by
// whoever writes it).
//
// `name_or_path` as in Character::Load. A model file "@REPOSITORY//PATH"
// becomes REPOSITORY/PATH, "$VARIABLE/PATH" VARIABLE/PATH, where FindModelFile
// looks first.
//
// Thread-safety: any thread. Blocking: reads the files, compiles the model.
// Errors: those of Character::Load; INVALID_ARGUMENT naming the file for one
// that the MJCF names outside its own folder.
absl::StatusOr<std::map<std::string, std::string>> CharacterFiles(
    const std::string& name_or_path);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_CHARACTER_FILES_H_
