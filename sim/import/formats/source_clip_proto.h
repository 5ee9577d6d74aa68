#ifndef SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_PROTO_H_
#define SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_PROTO_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/source_clip.pb.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// A clip as a message and back, without its name, `loops` and
// `quaternion_drift`: what the caller knows, and what no such reader sets.
v1::SourceClip ToProto(const SourceClip& clip);

// INVALID_ARGUMENT naming `source` and field unless the message is a clip as
// source_clip.h promises: sizes that fit, parents before children, different
// names, times that rise from 0, finite numbers, unit quaternions.
absl::StatusOr<SourceClip> FromProto(const v1::SourceClip& proto,
                                     absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_SOURCE_CLIP_PROTO_H_
