#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "common/check.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/made_files.h"

namespace {

const sinew::import::AsfSkeleton& Skeleton() {
  static const sinew::import::AsfSkeleton& skeleton = *[] {
    auto parsed =
        sinew::import::ParseAsf(sinew::import::testing::MadeAsf(), "made.asf");
    SINEW_CHECK(parsed.ok()) << parsed.status();
    return new sinew::import::AsfSkeleton(*std::move(parsed));
  }();
  return skeleton;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip =
      sinew::import::ParseAmc(bytes, Skeleton(), "clip", "fuzz.amc", {});
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  return 0;
}
