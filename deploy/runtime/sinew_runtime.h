/* Runs a policy bundle on a robot or in a simulator, from plain numbers.
 *
 * Plain C; link with libsinew_runtime.so. One control step, control_hz times a
 * second:
 *
 *   sinew_runtime* policy = sinew_open("bundle", error, sizeof error);
 *   sinew_load_library(policy, "library");           // or give frames yourself
 *   sinew_play(policy, "walk", 0.0, SINEW_ALIGN_TO_BODY);
 *   sinew_reset(policy, &state, NULL);
 *   for (;;) {
 *     ... fill state from sensors ...
 *     if (sinew_step(policy, &state, target) != 0) puts(sinew_error(policy));
 *     ... hand target to the joints' PD controllers ...
 *   }
 *   sinew_close(policy);
 *
 * A bundle with a latent (sinew_latent_width > 0) can also be steered without
 * any reference, by what lies in the latent (sinew_decode) or by chance
 * (sinew_sample).
 *
 * Conventions: SI units, world z up, quaternions w x y z, joints in the order
 * of sinew_joint_name(). J joints, F feet.
 *
 * Thread-safety: one thread per handle. Blocking: sinew_open and
 * sinew_load_library read files; sinew_play_nearest compares the body with up
 * to 32768 frames, which takes milliseconds, and reads them at its first call
 * for a kind, which may take a second and is better done before the loop; all
 * else computes for well under a millisecond and takes nothing from the heap
 * unless it fails. Errors: a function that returns int returns 0, or -1 with
 * the reason in sinew_error(), which names the field, what was expected and
 * what was found; the handle is then as it was before the call.
 *
 * MuJoCo's warning handler is one of the process: the first sinew_open sets one
 * that keeps what loading a character raises and hands all else to the handler
 * that was there before, if any (MuJoCo's own, which writes to the terminal and
 * to MUJOCO_LOG.TXT, is not called any more). Set yours before it, or after it
 * and for good; not while it runs.
 */
#ifndef SINEW_DEPLOY_RUNTIME_SINEW_RUNTIME_H_
#define SINEW_DEPLOY_RUNTIME_SINEW_RUNTIME_H_

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sinew_runtime sinew_runtime;

/* A body at one moment: the robot's state, or a frame of a reference. Arrays
 * are borrowed for the call. Zero the struct, then set what is known. */
typedef struct sinew_pose {
  const double* joint_position;        /* [J] rad */
  const double* joint_velocity;        /* [J] rad/s */
  const double* root_rotation;         /* [4] root to world */
  const double* root_angular_velocity; /* [3] rad/s in the ROOT's frame, as a
                                          gyroscope in it gives and MuJoCo has
                                          in qvel */
  /* What an IMU cannot give. NULL in a state: estimated (README.md), with the
   * lowest sole on the floor and standing still. Needed in a reference. */
  const double* root_position;        /* [3] m */
  const double* root_linear_velocity; /* [3] m/s, world */
  /* State only. NULL: the target that the last step returned. */
  const double* previous_target; /* [J] rad */
  /* Reference only; needed if sinew_needs_contact / sinew_needs_torque. */
  const double* contact;            /* [F] 1 where a foot bears weight */
  const double* feedforward_torque; /* [J] Nm */
} sinew_pose;

/* Reads and checks a bundle. NULL on failure, with the reason in `error`
 * (`error_size` bytes, may be 0). */
sinew_runtime* sinew_open(const char* bundle_directory, char* error,
                          size_t error_size);
/* NULL is allowed. */
void sinew_close(sinew_runtime* runtime);
/* The last error; "" if there was none. Valid until the next call. */
const char* sinew_error(const sinew_runtime* runtime);

/* What the policy is for. */
double sinew_control_hz(const sinew_runtime* runtime);
int sinew_joint_count(const sinew_runtime* runtime);
/* NULL if `joint` is out of range. */
const char* sinew_joint_name(const sinew_runtime* runtime, int joint);
/* Gains and limits that the targets are meant for: torque = stiffness (target
 * - q) - damping dq, limited. Each array [J], or NULL. */
void sinew_gains(const sinew_runtime* runtime, double* stiffness,
                 double* damping, double* torque_limit);
/* 1: the target moves linearly from the previous one over the control step;
 * 0: it jumps and is held. */
int sinew_ramps_target(const sinew_runtime* runtime);
int sinew_foot_count(const sinew_runtime* runtime);
int sinew_needs_contact(const sinew_runtime* runtime);
int sinew_needs_torque(const sinew_runtime* runtime);

/* A reference from a motion library (`sinew motion import`) of the same
 * character and rate. */
int sinew_load_library(sinew_runtime* runtime, const char* library_directory);
int sinew_clip_count(const sinew_runtime* runtime);
const char* sinew_clip_name(const sinew_runtime* runtime, int clip);
enum {
  SINEW_ALIGN_NONE = 0,   /* the clip's own place in the world */
  SINEW_ALIGN_TO_BODY = 1 /* each sinew_reset moves it to where the body stands
                             and turns it to where it heads */
};
/* From `seconds` (>= 0) into a clip, at its end at most. Then sinew_reset. */
int sinew_play(sinew_runtime* runtime, const char* clip, double seconds,
               int align);
/* Frames of the library's clips (but for those that are left out of training)
 * that a body can go on from. */
enum {
  SINEW_AMONG_ALL = 0,     /* all that are followed by half a second */
  SINEW_AMONG_GET_UPS = 1, /* those of clips from the floor to standing, until
                              the body leaves the floor */
  SINEW_AMONG_UPRIGHT = 2  /* those from which a body is upright for a second */
};
/* Plays from the frame that is nearest to the body, moved over the floor to
 * where it is and heads. That frame stands for `stand` steps (0 to 65536)
 * before the clip goes on, unless sinew_seek moves it: sinew_reference then
 * shows what comes once it goes on. An episode that has begun goes on, and so
 * does its previous target; else sinew_reset. `distance`, or NULL: how far the
 * body is off that frame, m, mean over the tracked bodies; where it is too far
 * to be followed, 0.5 m say, the body has fallen. Where the body is not on its
 * feet, give the state's root_position and root_linear_velocity. */
int sinew_play_nearest(sinew_runtime* runtime, const sinew_pose* state,
                       int among, int stand, double* distance);
/* For how many steps the first frame of a get-up stood when the policy learnt
 * to follow one; 0: it has not. */
int sinew_get_up_steps(const sinew_runtime* runtime);
/* The clip that plays, NULL if none does, until a library is loaded or the
 * handle closed; and the time in it of now, s, which counts on where it loops.
 */
const char* sinew_clip_playing(const sinew_runtime* runtime);
double sinew_clip_seconds(const sinew_runtime* runtime);
/* Moves on in the clip that plays, e.g. after missed steps. */
int sinew_seek(sinew_runtime* runtime, double seconds);
/* 1 if the clip that plays is over (its last frame is held). */
int sinew_clip_is_over(const sinew_runtime* runtime);
/* The clip's frame `ahead` (>= 0) control steps from now; arrays as in
 * sinew_pose, each or NULL. */
int sinew_reference(sinew_runtime* runtime, int ahead, double* root_position,
                    double* root_rotation, double* root_linear_velocity,
                    double* root_angular_velocity, double* joint_position,
                    double* joint_velocity);

/* A reference that the caller makes: frames that sinew_step_to wants, and how
 * many control steps ahead frame `index` lies (-1 if out of range). */
int sinew_frame_count(const sinew_runtime* runtime);
int sinew_frame_ahead(const sinew_runtime* runtime, int index);

/* Begins an episode at `state`. `reference`: the frame of now; NULL where a
 * clip plays or the bundle has a latent. */
int sinew_reset(sinew_runtime* runtime, const sinew_pose* state,
                const sinew_pose* reference);
/* One control step: targets [J] rad from the state. The clip that plays moves
 * on by a frame. */
int sinew_step(sinew_runtime* runtime, const sinew_pose* state, double* target);
/* The same with the caller's frames [sinew_frame_count()]. */
int sinew_step_to(sinew_runtime* runtime, const sinew_pose* state,
                  const sinew_pose* frames, double* target);

/* Bundles with a latent of Z numbers, of which S leading columns of the
 * observation are the body's own state. Both are 0 for other bundles, and the
 * functions below then fail with "this bundle has no latent". Sizes that are
 * given must be Z (S); numbers are rounded to single precision. */
int sinew_latent_width(const sinew_runtime* runtime);
int sinew_self_observation_width(const sinew_runtime* runtime);
/* What prior and decoder see of a state: the input "self_observation" of the
 * bundle's prior.onnx, decoder.onnx and sample.onnx. */
int sinew_self_observation(sinew_runtime* runtime, const sinew_pose* state,
                           double* observation, int size);
/* Mean and standard deviation of the latent, [size] each: that the reference
 * asks for, after a sinew_reset. `frames`: as in sinew_step_to; NULL: the clip
 * that plays, which moves on by a frame. sinew_decode of the mean then gives
 * the target of sinew_step. */
int sinew_encode(sinew_runtime* runtime, const sinew_pose* state,
                 const sinew_pose* frames, double* mean, double* std, int size);
/* The same without a reference: what this body would do next by itself. */
int sinew_prior(sinew_runtime* runtime, const sinew_pose* state, double* mean,
                double* std, int size);
/* One control step: targets [J] rad of a latent [size]; of N(0, 1) noise [size]
 * that becomes a latent around the prior's mean. They need a reset only where
 * the policy observes the previous target before any reference; theirs counts
 * as the previous one, as sinew_step's does. */
int sinew_decode(sinew_runtime* runtime, const sinew_pose* state,
                 const double* latent, int size, double* target);
int sinew_sample(sinew_runtime* runtime, const sinew_pose* state,
                 const double* noise, int size, double* target);

#ifdef __cplusplus
}
#endif

#endif /* SINEW_DEPLOY_RUNTIME_SINEW_RUNTIME_H_ */
