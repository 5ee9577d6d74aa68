#ifndef SINEW_TOOLS_ZOO_CARD_FACTS_H_
#define SINEW_TOOLS_ZOO_CARD_FACTS_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/clock.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/motion.pb.h"

namespace sinew::zoo {

// Where a card's facts lie.
struct CardOptions {
  std::string bundle;   // folder
  std::string motions;  // library folder
  std::string eval;     // what `sinew eval` wrote; empty: none
  std::string fallen;   // the same with fallen starts; empty: `eval`'s, if any
  std::string samples;  // what `sinew sample` wrote; empty: none
  std::string run;      // run directory, of a procedure too; empty: none
  std::string command;  // that trained; empty: what the recipe amounts to
  std::string machine;  // in words; empty: what the run says
};

// What a run says of its training.
struct RunFacts {
  std::string recipe;  // its name, and its seed
  uint64_t seed = 0;
  std::string cpu_class;  // CpuClass(); empty: unknown
  // Of metrics.jsonl; of a procedure, those of its newest stage but for
  // samples and seconds, which are sums over its stages (learner::CostOf).
  int64_t cores = 0;
  int64_t samples = 0;
  double train_seconds = 0;
  std::vector<std::string> decisions;  // of a procedure, in its words
};

struct CardFacts {
  bundle::Bundle bundle;
  int64_t bundle_bytes = 0;
  v1::MotionLibrary library;
  std::string library_sha256;
  nlohmann::json evaluation;    // null: none
  std::string evaluation_file;  // where it was read
  nlohmann::json fallen;        // its object `fallen`; null: none
  nlohmann::json samples;       // of its prior; null: none
  RunFacts run;                 // without a run: what the manifest says
  std::string command;
  std::string machine;
};

// Reads all of it.
//
// Thread-safety: any thread. Ownership: none kept. Blocking: on the disk.
// Errors: those of ReadBundle, CheckBundleBytes and Library::Load;
// INVALID_ARGUMENT naming file and field, expected and found: an evaluation or
// samples of another bundle or library, a run without rows, or of another
// recipe than the bundle's.
absl::StatusOr<CardFacts> ReadCardFacts(const CardOptions& options,
                                        const Clock& clock);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_CARD_FACTS_H_
