#ifndef SINEW_LEARNER_TORCH_HOST_VIEW_H_
#define SINEW_LEARNER_TORCH_HOST_VIEW_H_

#include <ATen/ATen.h>

#include "absl/types/span.h"

namespace sinew::learner {

// Host numbers as a tensor that shares their memory on the CPU, which must
// outlive it. libtorch wants a mutable pointer; what is made here is only read.
// Throws c10::Error.
template <typename T>
at::Tensor HostView(absl::Span<const T> values, at::IntArrayRef shape,
                    at::ScalarType type) {
  return at::from_blob(const_cast<T*>(values.data()), shape, type);
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_HOST_VIEW_H_
