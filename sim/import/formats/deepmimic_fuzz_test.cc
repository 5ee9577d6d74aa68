#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "sim/import/formats/deepmimic.h"
#include "sim/import/formats/testing/check_clip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip =
      sinew::import::ParseDeepMimic(bytes, "clip", "fuzz.json", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  return 0;
}
