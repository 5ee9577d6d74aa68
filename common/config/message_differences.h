#ifndef SINEW_COMMON_CONFIG_MESSAGE_DIFFERENCES_H_
#define SINEW_COMMON_CONFIG_MESSAGE_DIFFERENCES_H_

#include <string>

#include "google/protobuf/message.h"

namespace sinew {

// The fields in which two messages of a type differ, in a line: "modified:
// physics_hz: 120 -> 240; added: ...". Empty: they are equal. Pure; aborts for
// messages of two types.
std::string MessageDifferences(const google::protobuf::Message& expected,
                               const google::protobuf::Message& found);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_MESSAGE_DIFFERENCES_H_
