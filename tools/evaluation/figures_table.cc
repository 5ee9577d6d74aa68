#include "tools/evaluation/figures_table.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "common/json_fields.h"
#include "common/status_macros.h"
#include "tools/evaluation/same_task.h"

namespace sinew::evaluation {
namespace {

using Json = nlohmann::json;

constexpr char kNothing[] = "-";

// Null where there is nothing.
Json At(const Json& object, const char* key) {
  if (!object.is_object()) return Json();
  const auto found = object.find(key);
  return found == object.end() ? Json() : *found;
}

// One policy's clips of one kind.
struct Split {
  Json set;
  Json errors;  // whose four errors are shown
};

absl::StatusOr<Split> SplitOf(const Json& file, const TableRow& row,
                              const char* key) {
  Split split = {.set = At(file, key), .errors = Json()};
  if (split.set.is_null()) return split;
  split.errors = At(split.set, "successful");
  if (split.errors.is_object()) return split;
  return UnfitField(row.file, absl::StrCat(key, ".successful"),
                    "a set of clips", "none: evaluate the bundle anew");
}

absl::StatusOr<Json> Parse(const TableRow& row) {
  Json file = Json::parse(row.json, nullptr, /*allow_exceptions=*/false);
  if (!file.is_object()) {
    return UnfitField(row.file, "file", "a JSON object", "something else");
  }
  for (const char* key : {"overall", "successful", "zero_action", "library"}) {
    if (At(file, key).is_object()) continue;
    return UnfitField(row.file, key, "an object, as `sinew eval` writes",
                      "something else");
  }
  return file;
}

std::string Succeeded(const Json& set) {
  const Json clips = At(set, "clips");
  const Json succeeded = At(set, "succeeded_clips");
  if (!clips.is_number_integer() || !succeeded.is_number_integer() ||
      clips.get<int64_t>() <= 0) {
    return kNothing;
  }
  const auto all = clips.get<int64_t>(), some = succeeded.get<int64_t>();
  return absl::StrFormat(
      "%.1f %% (%d/%d)",
      100 * static_cast<double>(some) / static_cast<double>(all), some, all);
}

std::string Error(const Json& set, const char* key) {
  const Json value = At(set, key);
  const Json frames = At(set, "frames");
  if (!value.is_number() || !frames.is_number() || frames.get<double>() <= 0) {
    return kNothing;
  }
  return absl::StrFormat("%.1f", value.get<double>());
}

void AddCells(const Split& split, std::string* line) {
  absl::StrAppend(line, " ", Succeeded(split.set), " |");
  for (const char* key : {"e_g_mpjpe_mm", "e_mpjpe_mm", "e_acc", "e_vel"}) {
    absl::StrAppend(line, " ", Error(split.errors, key), " |");
  }
}

// Of clips trained on; without a split, all are.
absl::StatusOr<Split> TrainingOf(const Json& file, const TableRow& row) {
  if (At(file, "training").is_null()) {
    return Split{.set = At(file, "overall"), .errors = At(file, "successful")};
  }
  return SplitOf(file, row, "training");
}

absl::StatusOr<std::string> Line(const Json& file, const TableRow& row) {
  std::string line = absl::StrCat("| ", TableCell(row.name), " |");
  SINEW_ASSIGN_OR_RETURN(const Split training, TrainingOf(file, row));
  SINEW_ASSIGN_OR_RETURN(const Split left_out, SplitOf(file, row, "left_out"));
  AddCells(training, &line);
  AddCells(left_out, &line);
  absl::StrAppend(&line, " ", Succeeded(At(file, "imported")), " |\n");
  return line;
}

// What the zero action comes to under a policy's action law.
std::string ZeroActionCells(const Json& file) {
  const Json training = At(file, "training");
  const Json zero = At(training.is_null() ? file : training, "zero_action");
  const Json left_out = At(At(file, "left_out"), "zero_action");
  std::string cells;
  AddCells({.set = zero, .errors = zero}, &cells);
  AddCells({.set = left_out, .errors = left_out}, &cells);
  return cells;
}

// A row for each set of figures, named after its policies where there are
// several.
class ZeroActions {
 public:
  void Add(const std::string& policy, const std::string& cells) {
    for (Figures& one : figures_) {
      if (one.cells != cells) continue;
      absl::StrAppend(&one.policies, ", ", TableCell(policy));
      return;
    }
    figures_.push_back({.policies = TableCell(policy), .cells = cells});
  }

  std::string Lines() const {
    std::string lines;
    for (const Figures& one : figures_) {
      const std::string whose =
          figures_.size() == 1 ? "" : absl::StrCat(" of ", one.policies);
      absl::StrAppend(&lines, "| zero action", whose,
                      ", errors until it fails |", one.cells, " ", kNothing,
                      " |\n");
    }
    return lines;
  }

 private:
  struct Figures {
    std::string policies;
    std::string cells;
  };
  std::vector<Figures> figures_;
};

}  // namespace

std::string TableCell(const std::string& text) {
  return absl::StrReplaceAll(
      text, {{"|", "\\|"}, {"\n", " "}, {"<", "&lt;"}, {">", "&gt;"}});
}

absl::StatusOr<std::string> FiguresTable(absl::Span<const TableRow> rows) {
  if (rows.empty()) {
    return absl::InvalidArgumentError(
        "table: expected files that `sinew eval` wrote, found none");
  }
  std::string table =
      "| policy | trained on: Succ | E_g-mpjpe | E_mpjpe | E_acc | E_vel | "
      "left out: Succ | E_g-mpjpe | E_mpjpe | E_acc | E_vel | of everything "
      "imported |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  Json first;
  ZeroActions zero_actions;
  for (const TableRow& row : rows) {
    if (row.name.empty()) {
      return UnfitField(row.file, "name in the table", "one", "none");
    }
    SINEW_ASSIGN_OR_RETURN(const Json file, Parse(row));
    if (first.is_null()) first = file;
    SINEW_RETURN_IF_ERROR(CheckSameTask(first, file, row.file));
    SINEW_ASSIGN_OR_RETURN(const std::string line, Line(file, row));
    absl::StrAppend(&table, line);
    zero_actions.Add(row.name, ZeroActionCells(file));
  }
  absl::StrAppend(&table, zero_actions.Lines());
  return table;
}

}  // namespace sinew::evaluation
