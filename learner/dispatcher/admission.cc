#include "learner/dispatcher/admission.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew::learner {

absl::Status CheckAdmission(const Admission& expected,
                            const v1::ActorMessage::Register& actor) {
  const auto differs = [&actor](absl::string_view field,
                                absl::string_view wanted,
                                absl::string_view found) {
    return absl::FailedPreconditionError(
        absl::StrCat("actor ", actor.name(), ": ", field, ": expected ", wanted,
                     ", found ", found));
  };
  if (actor.protocol_version() != kDispatchProtocolVersion) {
    return differs("protocol version", absl::StrCat(kDispatchProtocolVersion),
                   absl::StrCat(actor.protocol_version()));
  }
  if (actor.build() != expected.build) {
    return differs("build", expected.build, actor.build());
  }
  if (actor.mujoco_version() != expected.mujoco_version) {
    return differs("MuJoCo version", expected.mujoco_version,
                   actor.mujoco_version());
  }
  if (actor.cpu_class() != expected.cpu_class) {
    return differs("CPU class", expected.cpu_class, actor.cpu_class());
  }
  if (actor.threads() < 1) {
    return differs("threads", ">= 1", absl::StrCat(actor.threads()));
  }
  return absl::OkStatus();
}

}  // namespace sinew::learner
