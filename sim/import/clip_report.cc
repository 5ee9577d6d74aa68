#include "sim/import/clip_report.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace sinew::import {
namespace {

using Json = nlohmann::json;
using Quality = v1::ClipQuality;

// Figures of report.json, units in their names.
struct Figure {
  const char* name;
  double scale;
  double (*value)(const Quality& quality);
};

constexpr Figure kFigures[] = {
    {"foot_skate_cm_per_s", 100,
     [](const Quality& q) { return q.foot_skate_m_per_s(); }},
    {"penetration_cm", 100,
     [](const Quality& q) { return q.penetration_max_m(); }},
    {"foot_penetration_p99_cm", 100,
     [](const Quality& q) { return q.foot_penetration_p99_m(); }},
    {"floating_cm", 100, [](const Quality& q) { return q.floating_mean_m(); }},
    {"self_penetration_cm", 100,
     [](const Quality& q) { return q.self_penetration_max_m(); }},
    {"self_penetration_added_cm", 100,
     [](const Quality& q) { return q.self_penetration_added_m(); }},
    {"airborne_percent", 100,
     [](const Quality& q) { return q.airborne_share(); }},
    {"joint_limit_violations_percent", 100,
     [](const Quality& q) { return q.joint_limit_violation_share(); }},
    {"peak_joint_speed_rad_per_s", 1,
     [](const Quality& q) { return q.peak_joint_speed(); }},
    {"peak_joint_acceleration_rad_per_s2", 1,
     [](const Quality& q) { return q.peak_joint_acceleration(); }},
    {"peak_root_speed_m_per_s", 1,
     [](const Quality& q) { return q.peak_root_speed(); }},
    {"retarget_error_cm", 100,
     [](const Quality& q) { return q.retarget_error_m(); }},
    {"joint_fit_mean_rad", 1,
     [](const Quality& q) { return q.joint_fit_mean_rad(); }},
    {"joint_fit_max_rad", 1,
     [](const Quality& q) { return q.joint_fit_max_rad(); }},
    {"residual_force_bodyweights", 1,
     [](const Quality& q) { return q.residual_force_bodyweights(); }},
    {"residual_torque_nm", 1,
     [](const Quality& q) { return q.residual_torque_nm(); }},
    {"peak_torque_ratio", 1,
     [](const Quality& q) { return q.peak_torque_ratio(); }},
    {"loop_seam_cm", 100, [](const Quality& q) { return q.loop_seam_m(); }},
};

// JSON has no infinities; null says that there is no number.
Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json SourceJson(const v1::ClipSource& source) {
  return {{"format", source.format()},
          {"frames_per_second", Number(source.frames_per_second())},
          {"metres_per_unit", Number(source.metres_per_unit())},
          {"up_axis", source.up_axis()},
          {"quaternion_order", source.quaternion_order()},
          {"map", source.map()},
          {"concluded", std::vector<std::string>(source.concluded().begin(),
                                                 source.concluded().end())}};
}

void AddMeasurements(const ClipReport& report, Json* clip) {
  const v1::ClipInfo& info = report.info;
  (*clip)["seconds"] = Number(report.duration_s);
  (*clip)["frames"] = info.num_frames();
  (*clip)["loops"] = info.loops();
  (*clip)["trial"] = info.trial();
  (*clip)["left_out"] = info.left_out();
  (*clip)["retiming"] = Number(report.retiming);
  (*clip)["supported_percent"] = Number(100 * report.supported_share);
  (*clip)["source"] = SourceJson(info.source());
  if (info.has_blend()) {
    const v1::BlendedClip& next = info.blend();
    (*clip)["blend"] = {{"file", next.source_file()},
                        {"trial", next.trial()},
                        {"gap_seconds", Number(next.gap_s())},
                        {"source", SourceJson(next.source())}};
  }
  Json figures = Json::object();
  for (const Figure& figure : kFigures) {
    figures[figure.name] = Number(figure.scale * figure.value(info.quality()));
  }
  (*clip)["figures"] = std::move(figures);
  Json errors = Json::array();
  for (const v1::RetargetError& error : info.quality().retarget_errors()) {
    errors.push_back({{"joint", error.joint()},
                      {"mean_cm", Number(100 * error.mean_m())},
                      {"max_cm", Number(100 * error.max_m())}});
  }
  (*clip)["retarget_errors"] = std::move(errors);
  (*clip)["import_core_seconds"] = Number(report.core_seconds);
  (*clip)["cache_key"] = report.cache_key;
}

Json ClipJson(const ClipReport& report) {
  Json clip = {{"file", report.file},
               {"name", report.name},
               {"status", StatusName(report.verdict.status)},
               {"reason", report.verdict.reason},
               {"findings", report.verdict.findings},
               {"warnings", report.warnings}};
  if (report.measured()) AddMeasurements(report, &clip);
  return clip;
}

Json LimitsJson() {
  Json limits = Json::array();
  for (const QualityLimit& limit : QualityLimits()) {
    limits.push_back({{"figure", limit.figure},
                      {"unit", limit.unit},
                      {"warn", Number(limit.warn)},
                      {"reject", Number(limit.reject)}});
  }
  return limits;
}

}  // namespace

Json ReportJson(absl::Span<const ClipReport> reports,
                const std::string& character, double rate) {
  Json counts = {{"ok", 0}, {"warned", 0}, {"rejected", 0}};
  Json clips = Json::array();
  for (const ClipReport& report : reports) {
    const std::string status(StatusName(report.verdict.status));
    counts[status] = counts[status].get<int>() + 1;
    clips.push_back(ClipJson(report));
  }
  return {{"character", character},
          {"frames_per_second", rate},
          {"counts", std::move(counts)},
          {"limits", LimitsJson()},
          {"clips", std::move(clips)}};
}

}  // namespace sinew::import
