#ifndef SINEW_COMMON_CONFIG_FIELD_CHECKER_H_
#define SINEW_COMMON_CONFIG_FIELD_CHECKER_H_

#include <cmath>
#include <string>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"

namespace sinew {

// Checks fields of a configuration one after the other and keeps the first
// violation: "SUBJECT field PATH: expected WHAT, found VALUE". NaN and
// infinities violate every range.
//
// Thread-safety: one thread. Blocking: never. Errors: in status().
class FieldChecker {
 public:
  // `subject` names the kind of configuration, e.g. "recipe".
  explicit FieldChecker(absl::string_view subject) : subject_(subject) {}

  // OK, or INVALID_ARGUMENT for the first violation.
  const absl::Status& status() const { return status_; }

  template <typename T>
  void Require(bool holds, absl::string_view path, absl::string_view expected,
               const T& found) {
    if (holds || !status_.ok()) return;
    status_ = absl::InvalidArgumentError(absl::StrCat(subject_, " field ", path,
                                                      ": expected ", expected,
                                                      ", found ", Show(found)));
  }

  template <typename T>
  void Positive(T value, absl::string_view path) {
    Require(Finite(value) && value > 0, path, "> 0", value);
  }
  template <typename T>
  void AtLeast(T value, std::type_identity_t<T> least, absl::string_view path) {
    Require(Finite(value) && value >= least, path,
            absl::StrCat(">= ", Show(least)), value);
  }
  template <typename T>
  void Within(T value, std::type_identity_t<T> low,
              std::type_identity_t<T> high, absl::string_view path) {
    Require(value >= low && value <= high, path,
            absl::StrCat("within [", Show(low), ", ", Show(high), "]"), value);
  }
  // Without the bounds themselves.
  void Between(double value, double low, double high, absl::string_view path) {
    Require(value > low && value < high, path,
            absl::StrCat("within (", Show(low), ", ", Show(high), ")"), value);
  }

 private:
  template <typename T>
  static bool Finite(T value) {
    return std::isfinite(static_cast<double>(value));
  }
  template <typename T>
  static std::string Show(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_floating_point_v<T>) {
      return absl::StrFormat("%.10g", value);
    } else if constexpr (std::is_convertible_v<T, absl::string_view>) {
      return absl::StrCat("\"", value, "\"");
    } else {
      return absl::StrCat(value);
    }
  }

  const std::string subject_;
  absl::Status status_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_FIELD_CHECKER_H_
