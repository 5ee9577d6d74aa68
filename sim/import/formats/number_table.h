#ifndef SINEW_SIM_IMPORT_FORMATS_NUMBER_TABLE_H_
#define SINEW_SIM_IMPORT_FORMATS_NUMBER_TABLE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// Lines of numbers, all with as many columns.
struct NumberTable {
  // Names of the columns from the first line; empty: it held numbers.
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  std::vector<int> lines;  // [rows] where it stands in the text, from 1
};

// Reads text in which commas, semicolons or white space part the columns;
// empty lines do not count. INVALID_ARGUMENT naming `source`, line and column,
// expected and found: a number that is none or is not finite, more or fewer
// columns than the first line, no rows. Memory: a small multiple of the text.
absl::StatusOr<NumberTable> ParseNumberTable(absl::string_view text,
                                             absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_NUMBER_TABLE_H_
