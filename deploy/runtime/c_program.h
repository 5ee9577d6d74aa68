#ifndef SINEW_DEPLOY_RUNTIME_C_PROGRAM_H_
#define SINEW_DEPLOY_RUNTIME_C_PROGRAM_H_

/* A robot's program in C, for the test of the C interface: opens, plays, steps
 * 10 times at the reference itself. Returns 0 and the last target of joint 0,
 * or -1 with the reason in `error`. */
#ifdef __cplusplus
extern "C" {
#endif
int RunInC(const char* bundle, const char* library, const char* clip,
           double* target_of_joint_0, char* error, unsigned long error_size);
#ifdef __cplusplus
}
#endif

#endif /* SINEW_DEPLOY_RUNTIME_C_PROGRAM_H_ */
