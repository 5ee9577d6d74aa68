#ifndef SINEW_SIM_IMPORT_QUALITY_GATE_H_
#define SINEW_SIM_IMPORT_QUALITY_GATE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/motion.pb.h"

namespace sinew::import {

// The one place that says which clips are good enough to train on. Figures are
// those of v1::ClipQuality (definitions: retarget/quality.h); a figure above a
// limit warns or rejects.
//
// How the limits were chosen. A policy can only track what its body can do, so
// those that decide are physical: above one body weight of unexplained force in
// the mean, somebody else carries the body; joints faster than any motor or
// muscle (sprinters' knees reach 20 rad/s, kicks 30) mean that the angles jump;
// a body 10 cm in the floor or that never comes near it has the wrong ground or
// the wrong units. Warnings begin where clips still train but are worth a look:
// at about the worst tenth of good recordings.

// A clip that ends and is shorter than this is rejected whatever its figures
// say: it is over before a body can fall, so whoever tracks it succeeds.
inline constexpr double kShortestSeconds = 0.2;

enum class ClipStatus { kOk, kWarned, kRejected };

// "ok", "warned", "rejected".
absl::string_view StatusName(ClipStatus status);

// One figure and its limits.
struct QualityLimit {
  const char* figure;  // for people: "unexplained root force"
  const char* unit;    // of value and limits as shown
  double scale;        // shown = scale * figure in SI units
  double warn;         // above: warned; shown units
  double reject;       // above: rejected; infinity: never
  // The figure in SI units.
  double (*value)(const v1::ClipQuality& quality);
};

// All limits, the gravest first.
absl::Span<const QualityLimit> QualityLimits();

struct Verdict {
  ClipStatus status = ClipStatus::kOk;
  // The gravest finding, e.g. "unexplained root force 1.32 body weights, limit
  // 1"; empty: none.
  std::string reason;
  // Everything above a limit, gravest first.
  std::vector<std::string> findings;
};

// Holds the figures against the limits; a figure that is not finite rejects.
// Pure.
Verdict JudgeQuality(const v1::ClipQuality& quality);

// Why a clip of so many seconds is too short, e.g. "length 0.1 s, expected at
// least 0.2 s"; empty: it is not. Pure.
std::string TooShort(const v1::ClipInfo& clip, double seconds);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_QUALITY_GATE_H_
