#ifndef SINEW_TOOLS_SINEW_FINITE_RANGE_H_
#define SINEW_TOOLS_SINEW_FINITE_RANGE_H_

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace sinew::tools {

// Of every flag that is a floating-point number: finite and from `lowest` to
// `highest`. CLI::Range and its like compare, and no comparison turns NaN away.
// Refuses with "--flag: expected 0 to 60, found nan".
inline CLI::Validator FiniteRange(double lowest, double highest) {
  const std::string range = absl::StrCat(lowest, " to ", highest);
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        if (absl::SimpleAtod(text, &value) && std::isfinite(value) &&
            value >= lowest && value <= highest) {
          return "";
        }
        return absl::StrCat("expected ", range, ", found ", text);
      },
      absl::StrCat("in [", range, "]"));
}

// Of every --threads: more than any machine has is a slip of the hand.
inline CLI::Validator ThreadRange() { return CLI::Range(1, 4096); }

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_FINITE_RANGE_H_
