#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/testing/check_clip.h"

// A skeleton that is read must carry a motion without any bone's numbers, or
// refuse it.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sinew::import;  // NOLINT
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto skeleton = ParseAsf(bytes, "fuzz.asf");
  if (!skeleton.ok()) return 0;
  const auto clip = ParseAmc("1\n2\n", *skeleton, "clip", "fuzz.amc", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  return 0;
}
