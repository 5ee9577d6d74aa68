// Under the address sanitizer MuJoCo's headers call two functions that only its
// sanitized builds have; these lead to what its release builds have instead.
#include <mujoco/mujoco.h>

#ifdef mjUSEASAN
extern "C" {

void SinewMarkStack(mjData* data) __asm__("mj_markStack");
void SinewFreeStack(mjData* data) __asm__("mj_freeStack");

void mj__markStack(mjData* data) { SinewMarkStack(data); }
void mj__freeStack(mjData* data) { SinewFreeStack(data); }

}  // extern "C"
#endif
