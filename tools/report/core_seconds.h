#ifndef SINEW_TOOLS_REPORT_CORE_SECONDS_H_
#define SINEW_TOOLS_REPORT_CORE_SECONDS_H_

#include <string>
#include <vector>

#include "tools/report/run_record.h"

namespace sinew::report {

// One kind of work and the seconds that cores spent on it.
struct Stage {
  std::string name;
  std::string what;  // a few words
  double seconds = 0;
};

// Where the core-seconds of a run went. Work that threads did at the same time
// adds up; what is left of cores x wall time is "wait" (idle, or lent to
// others). The shares are of `total`, the sum over stages.
struct CoreSeconds {
  double cores = 0;  // that the run had; 0: unknown
  double wall = 0;   // seconds of the rows that are counted
  double total = 0;
  std::vector<Stage> stages;  // in the order of work; zeros left out
};

// From metrics rows: "seconds" of each, "cores" and "ranks" where given. Rows
// without "seconds" do not count. Without "cores", the cores are what the
// threads' seconds need, rounded up. Pure.
CoreSeconds CountCoreSeconds(const std::vector<Json>& rows);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_CORE_SECONDS_H_
