#ifndef SINEW_TOOLS_TRAINING_PROCEDURE_RECORD_H_
#define SINEW_TOOLS_TRAINING_PROCEDURE_RECORD_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "learner/procedure/procedure.h"

namespace sinew::tools {

// What is known of a procedure between two of its stages: procedure.json, JSON,
// two spaces, ends with a newline.
//
//   format_version   1
//   recipe_sha256    of the recipe's canonical text
//   assets           SHA-256 of character, model and, if there was an --init,
//                    its bundle's manifest; digest of the library
//   clips            {library, trained_on, left_out}: how many; cleaned_away:
//                    clips that the import turned away, by name, and why;
//                    absent where the library has no report
//   over             whether the last decision ends the procedure
//   samples, train_seconds
//                    of all finished stages but that of kind "single"
//   decisions        a sentence for each stage, and one for the end
//   end              of the last decision, if it ends the procedure: evidence
//   stages           of each: directory (below the run), kind, primitive, from
//                    (index of the stage whose weights it begins with, or -1),
//                    clips (empty: all), primitives (of a composer: stages),
//                    evidence {clips, hard, hard_before, hard_won, forgotten},
//                    samples (of "single" alone: after how many it ends),
//                    and, where it has ended, finished {end: "plateau" or
//                    "samples", iterations, samples, train_seconds,
//                    best_share and stalled (of its plateau), failed: clips
//                    trained on that its last weights fail; recovered {starts,
//                    within_3_s, within_5_s}: of fallen starts, where the stage
//                    had some}
//   comparison       once the single primitive has ended: procedure, single,
//                    each {directory (of the stage whose weights count),
//                    samples (that it took in all to get there), clips_failed
//                    (of those trained on)}
struct ProcedureRecord {
  // Fallen starts, and shares of them that stand and track again in time.
  struct Recovered {
    int starts = 0;
    double within_3_s = 0, within_5_s = 0;

    bool operator==(const Recovered&) const = default;
  };
  struct Entry {
    std::string directory;
    learner::Decision decision;  // .next is this stage
    std::optional<learner::FinishedStage> finished;
    // Of a stage that has ended and started on the floor as well.
    std::optional<Recovered> recovered = std::nullopt;
  };

  std::string recipe_sha256;
  std::map<std::string, std::string> assets;
  int library_clips = 0;
  int left_out_clips = 0;
  int trained_on_clips = 0;
  std::optional<std::map<std::string, std::string>> cleaned_away = {};
  std::vector<Entry> stages;
  // Why the procedure is over; unset: it is not.
  std::optional<learner::Decision> end;

  // Those that have ended: all, or all but the last.
  std::vector<learner::FinishedStage> Finished() const;
  // Whether it is known what the procedure came to: it is over, or only the
  // single primitive is still to end.
  bool Decided() const;
};

// Both are pure. ParseProcedure: DATA_LOSS naming `source` and what is wrong
// with it. What it reads is well formed; whether its stages follow from one
// another is the caller's to check.
std::string PrintProcedure(const ProcedureRecord& record);
absl::StatusOr<ProcedureRecord> ParseProcedure(const std::string& text,
                                               const std::string& source);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCEDURE_RECORD_H_
