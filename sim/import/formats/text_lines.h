#ifndef SINEW_SIM_IMPORT_FORMATS_TEXT_LINES_H_
#define SINEW_SIM_IMPORT_FORMATS_TEXT_LINES_H_

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// What the readers of text formats share.

// Numbers of text formats are finite and no larger than this in size: beyond
// it lies nothing but damage, below it nothing overflows.
inline constexpr double kMaxTextNumber = 1e9;
// Longest name of a joint or bone, bytes.
inline constexpr size_t kMaxNameBytes = 128;

// Most joints times frames that a file of so many bytes may have: a joint that
// moves takes at least two bytes a frame, and few joints do not move.
// Never more than kMaxRotations, 2 GiB of quaternions: four hours at 120 Hz of
// 38 joints.
inline constexpr size_t kMaxRotations = size_t{1} << 26;
inline constexpr size_t MaxRotations(size_t bytes) {
  return std::min(bytes + (size_t{1} << 22), kMaxRotations);
}

// The lines of a text, one after another. Lines end with LF, CR LF or CR; a
// byte order mark at the start is skipped.
//
//   TextLines lines(bytes);
//   while (lines.Next()) Use(lines.text(), lines.number());
//
// Thread-safety: none. Ownership: the bytes must outlive it and all that it
// gives. Blocking: never. Errors: none.
class TextLines {
 public:
  explicit TextLines(absl::string_view bytes);

  // Goes to the next line; false at the end.
  bool Next();

  // The line without white space at its ends.
  absl::string_view text() const { return text_; }
  // From 1; after the end the number of lines.
  int64_t number() const { return number_; }

 private:
  absl::string_view rest_;
  absl::string_view text_;
  int64_t number_ = 0;
};

// Bytes of the UTF-8 character at the front of `text`, which is not empty; 0 if
// there is none or it is a control character, which would garble whatever shows
// it.
size_t CharacterBytes(absl::string_view text);

// Takes the next word, that is up to white space, off the front of `text`;
// empty at the end.
absl::string_view TakeWord(absl::string_view* text);

// INVALID_ARGUMENT "<source>: line <line>: <what>".
absl::Status LineError(absl::string_view source, int64_t line,
                       absl::string_view what);

// A finite number of at most kMaxTextNumber in size; else INVALID_ARGUMENT
// with what was expected and found, to be put into a LineError.
absl::StatusOr<double> ParseNumber(absl::string_view word);

// `text` in quotes for a message: bytes that are no printable ASCII escaped,
// at most 40 of them.
std::string Quoted(absl::string_view text);

// RESOURCE_EXHAUSTED naming `source`: more than `most` bytes.
absl::Status CheckFileSize(absl::string_view bytes, int64_t most,
                           absl::string_view source);

// RESOURCE_EXHAUSTED naming `source`: more joints times frames than `most`,
// which is the MaxRotations of the file.
absl::Status CheckRotations(size_t joints, size_t frames, size_t most,
                            absl::string_view source);

// A name as UTF-8 without control characters: other bytes are escaped as
// "\xe9". INVALID_ARGUMENT (to be put into a LineError): empty or longer than
// kMaxNameBytes.
absl::StatusOr<std::string> ParseName(absl::string_view text);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_TEXT_LINES_H_
