#include "learner/dispatcher/admission.h"

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using Register = v1::ActorMessage::Register;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

const Admission kExpected = {
    .build = "b1", .mujoco_version = "4.0.0", .cpu_class = "x86-64-v3"};

Register MakeRegister() {
  Register actor;
  actor.set_protocol_version(kDispatchProtocolVersion);
  actor.set_build("b1");
  actor.set_mujoco_version("4.0.0");
  actor.set_cpu_class("x86-64-v3");
  actor.set_threads(2);
  actor.set_name("host/7");
  return actor;
}

TEST(Admission, AdmitsAnActorThatMatches) {
  EXPECT_THAT(CheckAdmission(kExpected, MakeRegister()), IsOk());
}

struct Mismatch {
  std::string name;
  std::function<void(Register&)> change;
  std::string message;
};

class AdmissionMismatch : public ::testing::TestWithParam<Mismatch> {};

TEST_P(AdmissionMismatch, IsRefusedWithWhatWasExpectedAndFound) {
  Register actor = MakeRegister();
  GetParam().change(actor);

  EXPECT_THAT(CheckAdmission(kExpected, actor),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "actor host/7: " + GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Fields, AdmissionMismatch,
    ::testing::Values(
        Mismatch{"protocol", [](Register& r) { r.set_protocol_version(2); },
                 "protocol version: expected 1, found 2"},
        Mismatch{"build", [](Register& r) { r.set_build("b2"); },
                 "build: expected b1, found b2"},
        Mismatch{"mujoco", [](Register& r) { r.set_mujoco_version("3.3.7"); },
                 "MuJoCo version: expected 4.0.0, found 3.3.7"},
        Mismatch{"cpu", [](Register& r) { r.set_cpu_class("x86-64-v4"); },
                 "CPU class: expected x86-64-v3, found x86-64-v4"},
        Mismatch{"threads", [](Register& r) { r.set_threads(0); },
                 "threads: expected >= 1, found 0"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace sinew::learner
