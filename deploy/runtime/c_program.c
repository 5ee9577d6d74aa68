#include "deploy/runtime/c_program.h"

#include <stdio.h>

#include "deploy/runtime/sinew_runtime.h"

enum { kMaxJoints = 64 };

static int Steps(sinew_runtime* policy, const char* library, const char* clip,
                 double* target) {
  double position[3], rotation[4], velocity[3], rate[3];
  double q[kMaxJoints], dq[kMaxJoints];
  sinew_pose state = {0};
  state.joint_position = q;
  state.joint_velocity = dq;
  state.root_rotation = rotation;
  state.root_angular_velocity = rate;
  if (sinew_load_library(policy, library) != 0) return -1;
  if (sinew_play(policy, clip, 0.0, SINEW_ALIGN_TO_BODY) != 0) return -1;
  for (int step = 0; step < 10; ++step) {
    if (sinew_reference(policy, 0, position, rotation, velocity, rate, q, dq)) {
      return -1;
    }
    if (step == 0 && sinew_reset(policy, &state, NULL) != 0) return -1;
    if (sinew_step(policy, &state, target) != 0) return -1;
  }
  return 0;
}

int RunInC(const char* bundle, const char* library, const char* clip,
           double* target_of_joint_0, char* error, unsigned long error_size) {
  double target[kMaxJoints] = {0};
  sinew_runtime* policy = sinew_open(bundle, error, error_size);
  if (policy == NULL) return -1;
  const int result = Steps(policy, library, clip, target);
  if (result != 0) snprintf(error, error_size, "%s", sinew_error(policy));
  *target_of_joint_0 = target[0];
  sinew_close(policy);
  return result;
}
