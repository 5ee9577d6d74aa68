#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "sim/import/formats/bvh.h"
#include "sim/import/formats/testing/check_clip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip = sinew::import::ParseBvh(bytes, "clip", "fuzz.bvh", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  return 0;
}
