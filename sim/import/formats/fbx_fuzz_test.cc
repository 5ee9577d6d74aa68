#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "common/check.h"
#include "sim/import/formats/fbx.h"
#include "sim/import/formats/testing/check_clip.h"

// The library runs in a process of its own, so that this is about what comes of
// its failures; a process a run makes it slow.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip = sinew::import::ParseFbx(bytes, "clip", "fuzz.fbx", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  SINEW_CHECK(clip.ok() ||
              clip.status().code() == absl::StatusCode::kInvalidArgument ||
              clip.status().code() == absl::StatusCode::kResourceExhausted)
      << clip.status();
  return 0;
}
