#ifndef SINEW_COMMON_STATUS_CONTEXT_H_
#define SINEW_COMMON_STATUS_CONTEXT_H_

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew {

// `status` with "context: " before its message, e.g. the file or the peer that
// it is about; OK stays OK. Pure.
inline absl::Status WithContext(const absl::Status& status,
                                absl::string_view context) {
  if (status.ok()) return status;
  return absl::Status(status.code(),
                      absl::StrCat(context, ": ", status.message()));
}

}  // namespace sinew

#endif  // SINEW_COMMON_STATUS_CONTEXT_H_
