#ifndef SINEW_SIM_CHARACTER_CHARACTER_TEXT_H_
#define SINEW_SIM_CHARACTER_CHARACTER_TEXT_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/character.pb.h"

namespace sinew::character {

// Parses the text form of a character and checks all that can be checked
// without its model: version, name, unique joints, finite gains in range,
// names that must not be empty. Fields that are unset keep that.
//
// Thread-safety: any thread. Blocking: never. Errors: INVALID_ARGUMENT naming
// `source`, the line or the field, what was expected and what was found.
absl::StatusOr<v1::Character> ParseCharacter(absl::string_view text,
                                             absl::string_view source);

// The text form, the same for equal messages.
std::string PrintCharacter(const v1::Character& character);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_CHARACTER_TEXT_H_
