#ifndef SINEW_COMMON_POLICY_ALIGNED_BUFFER_H_
#define SINEW_COMMON_POLICY_ALIGNED_BUFFER_H_

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "common/check.h"

namespace sinew::policy::internal {

// A fixed array of float32 zeros that starts on a cache line and whose length
// is rounded up to whole lines, so that vector loads never leave it.
class AlignedBuffer {
 public:
  AlignedBuffer() = default;
  explicit AlignedBuffer(int64_t size) {
    constexpr size_t kLine = 64;
    const size_t bytes = (size * sizeof(float) + kLine) / kLine * kLine;
    data_.reset(static_cast<float*>(std::aligned_alloc(kLine, bytes)));
    SINEW_CHECK(data_ != nullptr) << "no memory for " << bytes << " bytes";
    std::memset(data_.get(), 0, bytes);
  }

  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(float* data) const { std::free(data); }
  };
  std::unique_ptr<float, Free> data_;
};

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_ALIGNED_BUFFER_H_
