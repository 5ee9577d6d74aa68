#include "sim/import/formats/number_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/status_macros.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

constexpr size_t kMaxLine = 64 << 10;

using Cells = std::vector<absl::string_view>;

// Commas and semicolons part cells that may be empty, white space does not.
Cells SplitLine(absl::string_view line) {
  line = absl::StripAsciiWhitespace(line);
  for (const char separator : {',', ';'}) {
    if (!absl::StrContains(line, separator)) continue;
    Cells cells = absl::StrSplit(line, separator);
    // A separator that ends the line parts nothing.
    if (cells.size() > 1 && absl::StripAsciiWhitespace(cells.back()).empty()) {
      cells.pop_back();
    }
    for (absl::string_view& cell : cells) {
      cell = absl::StripAsciiWhitespace(cell);
    }
    return cells;
  }
  return absl::StrSplit(line, absl::ByAnyChar(" \t\v\f\r"), absl::SkipEmpty());
}

bool IsNumber(absl::string_view cell) {
  double value;
  return absl::SimpleAtod(cell, &value);
}

// Reads a first line that names columns, if it does: one that starts with #, or
// most of whose cells are no numbers.
std::vector<std::string> ReadNames(absl::string_view line) {
  const bool is_comment = absl::ConsumePrefix(&line, "#");
  const Cells cells = SplitLine(line);
  const auto numbers = std::count_if(cells.begin(), cells.end(), IsNumber);
  if (!is_comment && 2 * numbers >= static_cast<int64_t>(cells.size())) {
    return {};
  }
  std::vector<std::string> names;
  for (absl::string_view cell : cells) {
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') {
      cell = cell.substr(1, cell.size() - 2);
    }
    names.emplace_back(absl::StripAsciiWhitespace(cell));
  }
  return names;
}

absl::StatusOr<std::vector<double>> ReadRow(const Cells& cells,
                                            absl::string_view source,
                                            int line) {
  std::vector<double> row;
  row.reserve(cells.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    double value;
    if (!absl::SimpleAtod(cells[i], &value) || !std::isfinite(value)) {
      return absl::InvalidArgumentError(
          absl::StrCat(source, ": line ", line, ", column ", i + 1,
                       ": expected a finite number, found ", Quoted(cells[i])));
    }
    row.push_back(value);
  }
  return row;
}

}  // namespace

absl::StatusOr<NumberTable> ParseNumberTable(absl::string_view text,
                                             absl::string_view source) {
  NumberTable table;
  absl::ConsumePrefix(&text, "\xEF\xBB\xBF");  // byte order mark
  size_t columns = 0;
  int first_line = 0;
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty()) continue;
    if (line.size() > kMaxLine) {
      return absl::InvalidArgumentError(
          absl::StrCat(source, ": line ", line_number, ": expected at most ",
                       kMaxLine, " bytes, found ", line.size()));
    }
    if (first_line == 0) {
      first_line = line_number;
      table.names = ReadNames(line);
      columns = table.names.size();
      if (columns > 0) continue;
    }
    const Cells cells = SplitLine(line);
    if (columns == 0) columns = cells.size();
    if (cells.size() != columns) {
      return absl::InvalidArgumentError(absl::StrCat(
          source, ": line ", line_number, ": expected ", columns,
          " columns as in line ", first_line, ", found ", cells.size()));
    }
    SINEW_ASSIGN_OR_RETURN(std::vector<double> row,
                           ReadRow(cells, source, line_number));
    table.rows.push_back(std::move(row));
    table.lines.push_back(line_number);
  }
  if (table.rows.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected lines of numbers, found none"));
  }
  return table;
}

}  // namespace sinew::import
