#include "common/finite.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sinew {
namespace {

// A number is finite unless all bits of its exponent are set. Blocks are
// copied into an aligned array, which the compiler turns into vector loads, and
// have no branch inside.
template <typename Word, Word kExponent>
bool AllFinite(absl::string_view bytes) {
  constexpr size_t kBlock = 1024;
  Word block[kBlock];
  const size_t count = bytes.size() / sizeof(Word);
  for (size_t begin = 0; begin < count; begin += kBlock) {
    const size_t size = std::min(kBlock, count - begin);
    std::memcpy(block, bytes.data() + begin * sizeof(Word),
                size * sizeof(Word));
    Word bad = 0;
    for (size_t i = 0; i < size; ++i) {
      bad |= (block[i] & kExponent) == kExponent ? Word{1} : Word{0};
    }
    if (bad != 0) return false;
  }
  return true;
}

}  // namespace

bool AllFinite32(absl::string_view bytes) {
  return AllFinite<uint32_t, 0x7f800000u>(bytes);
}

bool AllFinite64(absl::string_view bytes) {
  return AllFinite<uint64_t, 0x7ff0000000000000u>(bytes);
}

}  // namespace sinew
