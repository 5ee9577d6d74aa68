#ifndef SINEW_LEARNER_DISPATCHER_ADMISSION_H_
#define SINEW_LEARNER_DISPATCHER_ADMISSION_H_

#include <string>

#include "absl/status/status.h"
#include "proto/sinew/v1/dispatch.pb.h"

namespace sinew::learner {

// Version of dispatch.proto that this build speaks.
inline constexpr int kDispatchProtocolVersion = 1;

// What an actor must present for its bytes to equal those of any other actor:
// bit equality is promised within one build and one CPU feature class.
struct Admission {
  std::string build;
  std::string mujoco_version;
  std::string cpu_class;
};

// OK, or FAILED_PRECONDITION "actor NAME: FIELD: expected X, found Y" for the
// first of protocol version, build, MuJoCo version, CPU class and threads that
// does not fit. Pure.
absl::Status CheckAdmission(const Admission& expected,
                            const v1::ActorMessage::Register& actor);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_ADMISSION_H_
