#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/robot_csv.h"
#include "sim/import/formats/testing/check_clip.h"

namespace {

// Layouts of 1 to 3, 23 and 29 joints: j0, j1 ...
const std::vector<sinew::v1::RobotLayout>& Layouts() {
  static const auto& layouts = *[] {
    auto* made = new std::vector<sinew::v1::RobotLayout>();
    for (const int joints : {1, 2, 3, 23, 29}) {
      sinew::v1::RobotLayout& layout = made->emplace_back();
      layout.set_name(absl::StrCat("robot_", joints));
      for (int i = 0; i < joints; ++i) layout.add_joints(absl::StrCat("j", i));
    }
    return made;
  }();
  return layouts;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto clip =
      sinew::import::ParseRobotCsv(bytes, "clip", "fuzz.csv", {}, Layouts());
  if (clip.ok()) sinew::import::testing::CheckClip(*clip);
  return 0;
}
