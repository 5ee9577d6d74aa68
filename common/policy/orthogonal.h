#ifndef SINEW_COMMON_POLICY_ORTHOGONAL_H_
#define SINEW_COMMON_POLICY_ORTHOGONAL_H_

#include <cstdint>

#include "common/policy/safetensors.h"
#include "common/random/philox.h"

namespace sinew::policy {

// An orthogonal weight matrix [out, in] float32 times `gain`: orthonormal rows
// if out <= in, else orthonormal columns. It is the Q of the QR factorisation
// (R with positive diagonal) of a matrix of independent normals drawn under
// `key`, so it is uniform over such matrices. Computed in double in a fixed
// order by Gram-Schmidt, twice over: equal on all machines of one build,
// whatever their caches.
//
// Thread-safety: pure function. Blocking: O(out * in * min(out, in)) work,
// 0.1 s for [512, 512]. Errors: none.
HostTensor OrthogonalWeight(int64_t out, int64_t in, double gain,
                            const RandomKey& key);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_ORTHOGONAL_H_
