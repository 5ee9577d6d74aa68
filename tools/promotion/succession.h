#ifndef SINEW_TOOLS_PROMOTION_SUCCESSION_H_
#define SINEW_TOOLS_PROMOTION_SUCCESSION_H_

#include "absl/status/status.h"
#include "proto/sinew/v1/bundle.pb.h"

namespace sinew::tools {

// Whether a candidate can stand where the incumbent stands, before any figure
// is looked at:
//
//   use    it has every graph of the incumbent, and a latent and an own state
//          of the same widths where the incumbent has them: who decodes latents
//          can load it. What a latent means is not compared: trained anew, it
//          means something else, and a policy over the old decoder is trained
//          again or keeps the old bundle (rollback).
//   world  physics, actuator model and, where evaluations are randomised,
//          randomisation are equal, defaults filled: else their figures are
//          about different tasks
//
// Thread-safety: pure. Blocking: never. Errors: FAILED_PRECONDITION naming the
// graph or field, expected (the incumbent's) and found.
absl::Status CheckSuccession(const v1::BundleManifest& incumbent,
                             const v1::BundleManifest& candidate);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PROMOTION_SUCCESSION_H_
