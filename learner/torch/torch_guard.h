#ifndef SINEW_LEARNER_TORCH_TORCH_GUARD_H_
#define SINEW_LEARNER_TORCH_TORCH_GUARD_H_

#include <c10/util/Exception.h>

#include <exception>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew::learner {

// Runs `body`, which returns absl::Status, and turns what libtorch throws into
// INTERNAL "`what`: <libtorch's message, without its stack>". No exception of
// libtorch passes this edge. For files that include libtorch only.
template <typename Body>
absl::Status CatchTorch(absl::string_view what, Body&& body) {
  try {
    return std::forward<Body>(body)();
  } catch (const c10::Error& error) {
    return absl::InternalError(
        absl::StrCat(what, ": ", error.what_without_backtrace()));
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat(what, ": ", error.what()));
  }
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_TORCH_GUARD_H_
