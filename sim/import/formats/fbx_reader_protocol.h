#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_READER_PROTOCOL_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_READER_PROTOCOL_H_

namespace sinew::import {

// Between ParseFbx and its child, fbx_reader IN OUT SOURCE UNIT UP RATE: the
// FBX file, the file to write, what messages call the former, and ReadOptions
// ("-": unset). It writes a v1::SourceClip and ends with kFbxDone, or writes a
// message and ends with one of the others.
inline constexpr int kFbxDone = 0;
inline constexpr int kFbxInvalid = 10;    // INVALID_ARGUMENT
inline constexpr int kFbxExhausted = 11;  // RESOURCE_EXHAUSTED
inline constexpr int kFbxBadUsage = 12;   // our bug

inline constexpr char kFbxUnset[] = "-";

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_READER_PROTOCOL_H_
