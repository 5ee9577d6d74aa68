#include "learner/curriculum/only_clips_check.h"

#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/nearest_name.h"

namespace sinew::learner {
namespace {

absl::Status Wrong(absl::string_view expected, absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat("recipe field task.start.only_clips: expected a clip of the "
                   "library ",
                   expected, ", found \"", found, "\""));
}

}  // namespace

absl::Status CheckOnlyClips(const v1::Start& start,
                            const v1::MotionLibrary& library) {
  std::vector<std::string> names;
  std::set<absl::string_view> all, left_out;
  for (const v1::ClipInfo& clip : library.clips()) {
    all.insert(clip.name());
    if (clip.left_out()) {
      left_out.insert(clip.name());
    } else {
      names.push_back(clip.name());
    }
  }
  for (const std::string& name : start.only_clips()) {
    if (left_out.contains(name)) {
      return Wrong("that is not left out of training", name);
    }
    if (!all.contains(name)) {
      return Wrong(
          absl::StrCat("(the nearest is \"", NearestName(name, names), "\")"),
          name);
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::learner
