#ifndef SINEW_SIM_IMPORT_CLIP_REPORT_H_
#define SINEW_SIM_IMPORT_CLIP_REPORT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "nlohmann/json.hpp"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/import/quality_gate.h"

namespace sinew::import {

// What became of one file.
struct ClipReport {
  std::string file;  // path as given; "FIRST + SECOND" of a blend
  std::string name;
  // OK: good enough for the library. Else why not: FAILED_PRECONDITION if the
  // quality gate rejected it (`info` is complete then), else the error of
  // reading or fitting it.
  absl::Status status;
  Verdict verdict;
  // Of a clip that was measured: its entry in the manifest.
  v1::ClipInfo info;
  double duration_s = 0;  // of the motion
  // Speed against the source, from rounding to whole frames.
  double retiming = 1;
  // Frames that the floor carries, share of all.
  double supported_share = 0;
  // Things worth knowing, one sentence each; they do not change the status.
  std::vector<std::string> warnings;
  // Seconds of one core that reading and fitting took.
  double core_seconds = 0;
  // Its entry in the cache (clip_cache.h), with frames and preview if the clip
  // was measured; empty: none.
  std::string cache_key;
  // Taken from an earlier import.
  bool from_cache = false;

  bool measured() const { return info.num_frames() > 0; }
};

// LIB/report.json:
//
//   {"character", "frames_per_second",
//    "counts": {"ok", "warned", "rejected"},
//    "limits": [{"figure", "unit", "warn", "reject"}],
//    "clips": [{
//      "file", "name", "status": "ok" | "warned" | "rejected", "reason",
//      "warnings": [...], "findings": [...],          of the gate, as sentences
//      and, of a clip that was measured:
//      "seconds", "frames", "loops", "trial", "left_out" (of training),
//      "retiming", "supported_percent",
//      "source": {"format", "frames_per_second", "metres_per_unit", "up_axis",
//                 "quaternion_order", "map", "concluded": [...]},
//      "blend": {"file", "trial", "gap_seconds", "source"},   of a blend
//      "figures": {...},                              see kFigures in the .cc
//      "retarget_errors": [{"joint", "mean_cm", "max_cm"}],
//      "import_core_seconds", "cache_key"}]}
//
// "reason" is empty for an ok clip. Pure.
nlohmann::json ReportJson(absl::Span<const ClipReport> reports,
                          const std::string& character, double rate);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_CLIP_REPORT_H_
