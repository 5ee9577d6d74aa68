#ifndef SINEW_TOOLS_REPORT_TESTING_RUN_ROWS_H_
#define SINEW_TOOLS_REPORT_TESTING_RUN_ROWS_H_

#include <string>
#include <vector>

#include "tools/report/run_record.h"

namespace sinew::report::testing {

// Rows 1 to `count` of a run's metrics.jsonl: two seconds of two cores per
// iteration; an evaluation every fifth.
std::vector<Json> Rows(int count);

// The same of a run over 8 bins, evaluated from the third row on.
std::vector<Json> RowsWithCurriculum(int count);

// metrics.jsonl with these rows.
std::string MetricsText(const std::vector<Json>& rows);

// A folder, made anew, with the recipe "toy_recipe" and 20 rows: what a run
// leaves while it trains. Aborts with a message on any error.
void WriteRun(const std::string& folder);

}  // namespace sinew::report::testing

#endif  // SINEW_TOOLS_REPORT_TESTING_RUN_ROWS_H_
