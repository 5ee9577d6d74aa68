#ifndef SINEW_COMMON_JSON_FIELDS_H_
#define SINEW_COMMON_JSON_FIELDS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew {

// Fields of JSON files of which nothing is certain; Json is nlohmann::json or
// nlohmann::ordered_json.
//
// Thread-safety: pure. Ownership: none. Blocking: never. Errors: none.

// What is at a path of keys ("seconds", "learn"); null: nothing.
template <typename Json>
const Json* FieldAt(const Json& object, const std::vector<std::string>& path) {
  const Json* at = &object;
  for (const std::string& key : path) {
    if (!at->is_object()) return nullptr;
    const auto it = at->find(key);
    if (it == at->end()) return nullptr;
    at = &*it;
  }
  return at;
}

// Number there; `otherwise` if it is absent or no number.
template <typename Json>
double NumberAt(const Json& object, const std::vector<std::string>& path,
                double otherwise = 0) {
  const Json* at = FieldAt(object, path);
  return at != nullptr && at->is_number() ? at->template get<double>()
                                          : otherwise;
}

// Text there; empty if it is absent or no text.
template <typename Json>
std::string TextAt(const Json& object, const std::vector<std::string>& path) {
  const Json* at = FieldAt(object, path);
  return at != nullptr && at->is_string() ? at->template get<std::string>()
                                          : "";
}

// INVALID_ARGUMENT: "FILE: FIELD: expected EXPECTED, found FOUND".
inline absl::Status UnfitField(absl::string_view file, absl::string_view field,
                               absl::string_view expected,
                               absl::string_view found) {
  return absl::InvalidArgumentError(absl::StrCat(
      file, ": ", field, ": expected ", expected, ", found ", found));
}

}  // namespace sinew

#endif  // SINEW_COMMON_JSON_FIELDS_H_
