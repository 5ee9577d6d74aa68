#include "sim/import/quality_gate.h"

#include <cmath>
#include <limits>

#include "absl/strings/str_format.h"

namespace sinew::import {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

using Quality = v1::ClipQuality;

constexpr QualityLimit kLimits[] = {
    {"unexplained root force", "body weights", 1, 0.35, 1.0,
     [](const Quality& q) { return q.residual_force_bodyweights(); }},
    {"largest depth below the floor", "cm", 100, 4, 10,
     [](const Quality& q) { return q.penetration_max_m(); }},
    {"depth of the feet below the floor (99th percentile)", "cm", 100, 2, 10,
     [](const Quality& q) { return q.foot_penetration_p99_m(); }},
    {"mean gap between body and floor in contact", "cm", 100, 3, 10,
     [](const Quality& q) { return q.floating_mean_m(); }},
    {"share of frames in the air", "%", 100, 50, 90,
     [](const Quality& q) { return q.airborne_share(); }},
    {"peak joint speed", "rad/s", 1, 30, 60,
     [](const Quality& q) { return q.peak_joint_speed(); }},
    {"peak joint acceleration", "rad/s^2", 1, 1200, 4000,
     [](const Quality& q) { return q.peak_joint_acceleration(); }},
    {"peak speed of the root", "m/s", 1, 8, 15,
     [](const Quality& q) { return q.peak_root_speed(); }},
    {"retargeting error", "cm", 100, 8, 30,
     [](const Quality& q) { return q.retarget_error_m(); }},
    {"mean joint angle lost to hinges", "rad", 1, 0.25, 1,
     [](const Quality& q) { return q.joint_fit_mean_rad(); }},
    {"angles beyond joint limits", "%", 100, 10, 60,
     [](const Quality& q) { return q.joint_limit_violation_share(); }},
    {"foot skate", "cm/s", 100, 15, 100,
     [](const Quality& q) { return q.foot_skate_m_per_s(); }},
    {"largest depth of a body in another", "cm", 100, 4, kNever,
     [](const Quality& q) { return q.self_penetration_max_m(); }},
    {"depth of a body in another beyond the source's", "cm", 100, 3, kNever,
     [](const Quality& q) { return q.self_penetration_added_m(); }},
    {"gap where the loop closes", "cm", 100, 8, 40,
     [](const Quality& q) { return q.loop_seam_m(); }},
    {"peak torque over its limit", "x", 1, 3, kNever,
     [](const Quality& q) { return q.peak_torque_ratio(); }},
};

std::string Finding(const QualityLimit& limit, double shown, double bound) {
  return absl::StrFormat("%s %.3g %s, limit %g", limit.figure, shown,
                         limit.unit, bound);
}

}  // namespace

absl::string_view StatusName(ClipStatus status) {
  switch (status) {
    case ClipStatus::kOk:
      return "ok";
    case ClipStatus::kWarned:
      return "warned";
    case ClipStatus::kRejected:
      return "rejected";
  }
  return "rejected";
}

absl::Span<const QualityLimit> QualityLimits() { return kLimits; }

Verdict JudgeQuality(const v1::ClipQuality& quality) {
  std::vector<std::string> rejecting, warning;
  for (const QualityLimit& limit : kLimits) {
    const double shown = limit.scale * limit.value(quality);
    // Written so that a figure that is not a number rejects.
    if (!(shown <= limit.reject) || !std::isfinite(shown)) {
      rejecting.push_back(Finding(limit, shown, limit.reject));
    } else if (shown > limit.warn) {
      warning.push_back(Finding(limit, shown, limit.warn));
    }
  }
  Verdict verdict;
  if (!warning.empty()) verdict.status = ClipStatus::kWarned;
  if (!rejecting.empty()) verdict.status = ClipStatus::kRejected;
  verdict.findings = std::move(rejecting);
  verdict.findings.insert(verdict.findings.end(), warning.begin(),
                          warning.end());
  if (!verdict.findings.empty()) verdict.reason = verdict.findings.front();
  return verdict;
}

std::string TooShort(const v1::ClipInfo& clip, double seconds) {
  if (clip.loops() || seconds >= kShortestSeconds) return "";
  return absl::StrFormat("length %.3g s, expected at least %g s", seconds,
                         kShortestSeconds);
}

}  // namespace sinew::import
