#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "common/check.h"
#include "sim/import/formats/keyframes.h"
#include "sim/import/formats/testing/check_clip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip =
      sinew::import::ParseKeyframes(bytes, "clip", "fuzz.xml", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  const auto markers =
      sinew::import::ParseMarkerKeyframes(bytes, "clip", "fuzz.xml", {});
  if (!markers.ok()) return 0;
  SINEW_CHECK(markers->positions.size() == markers->times.size());
  for (const auto& positions : markers->positions) {
    SINEW_CHECK(positions.size() == markers->markers.size());
  }
  return 0;
}
