#ifndef SINEW_COMMON_CONFIG_TEXT_PROTO_H_
#define SINEW_COMMON_CONFIG_TEXT_PROTO_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "google/protobuf/message.h"

namespace sinew {

// Parses protobuf's text format into `message`, whose former content is lost
// also on failure. INVALID_ARGUMENT for the first error: unknown field, wrong
// type, value out of the type's range, field given twice, syntax, groups
// nested deeper than 64, text of 64 MiB or more:
//
//   walk.textproto:7:3: Message type "sinew.v1.Ppo" has no field named "epoch".
//   in: epoch: 3
//
// (on one line). `source` names the file or peer. Pure; never blocks.
absl::Status ParseTextProto(absl::string_view text, absl::string_view source,
                            google::protobuf::Message& message);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_TEXT_PROTO_H_
