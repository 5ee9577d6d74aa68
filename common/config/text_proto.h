#ifndef SINEW_COMMON_CONFIG_TEXT_PROTO_H_
#define SINEW_COMMON_CONFIG_TEXT_PROTO_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "google/protobuf/message.h"

namespace sinew {

// Parses protobuf's text format into `message` (which is cleared first).
// INVALID_ARGUMENT "FILE:LINE:COLUMN: what is wrong" for the first error:
// unknown field, wrong type, value out of the type's range, syntax. Pure;
// `source` names the file or peer.
absl::Status ParseTextProto(absl::string_view text, absl::string_view source,
                            google::protobuf::Message& message);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_TEXT_PROTO_H_
