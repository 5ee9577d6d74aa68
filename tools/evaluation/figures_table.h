#ifndef SINEW_TOOLS_EVALUATION_FIGURES_TABLE_H_
#define SINEW_TOOLS_EVALUATION_FIGURES_TABLE_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"

namespace sinew::evaluation {

// One policy: what it is called, and the file that `sinew eval` wrote of it.
struct TableRow {
  std::string name;
  std::string file;  // for messages
  std::string json;  // its text (evaluation_json.h)
};

// Table 1 of PULSE (Luo et al., 2024) in Markdown: per row the clips that
// succeed, and E_g-mpjpe and E_mpjpe (mm), E_acc (mm/frame^2) and E_vel
// (mm/frame) of the successful, of clips trained on and of clips left out; then
// the share of everything imported, where that is known. The last row is the
// zero action on the same clips, whose errors are of all clips until they fail;
// what it does is the policies' action law, so there is such a row for each set
// of figures that differs.
//
// Thread-safety: pure. Blocking: never. Errors: INVALID_ARGUMENT naming the
// file and field: no rows, no name, no such file, or one of another library,
// starts, seconds, randomisation or fall distance than the first.
absl::StatusOr<std::string> FiguresTable(absl::Span<const TableRow> rows);

// Text as one cell of a table in Markdown: it stays text. Pure.
std::string TableCell(const std::string& text);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_FIGURES_TABLE_H_
