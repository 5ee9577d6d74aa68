#include "tools/sampling/sampling_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "sim/metrics/foot_skate.h"
#include "tools/sampling/sample_starts.h"

namespace sinew::sampling {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kColumns[] =
    "%-12s %7s %9s %8s %7s %9s %9s %9s %9s %9s %9s %9s\n";

Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// Of a foot that never touched the floor nobody knows how it slides.
Json SkateNumber(const metrics::FootSkate& skate) {
  return skate.contacts > 0 ? Json(skate.mean_m_per_s()) : Json(nullptr);
}

Json LatentObject(const metrics::LatentContinuity& latent) {
  if (latent.steps == 0) return nullptr;
  return {{"step", latent.step},
          {"spread", latent.spread},
          {"ratio", latent.ratio}};
}

Json TransitionsObject(const metrics::TransitionFigures& figures, int64_t all) {
  return {{"generated", figures.generated},
          {"generated_all", all},
          {"library", figures.library},
          {"distance", figures.distance},
          {"squared_distance_all", figures.squared},
          {"squared_distance_within_threshold", Number(figures.squared_within)},
          {"far_share", figures.far_share},
          {"coverage", figures.coverage},
          {"matched_share", figures.matched}};
}

Json Curve(const std::vector<double>& shares) {
  Json curve = Json::array();
  for (size_t i = 0; i < shares.size(); ++i) {
    curve.push_back(
        {{"threshold", kCoverageThresholds[i]}, {"coverage", shares[i]}});
  }
  return curve;
}

Json Rows(const std::vector<SampleRow>& rows) {
  Json array = Json::array();
  for (const SampleRow& row : rows) {
    array.push_back({{"start", row.start},
                     {"seconds", row.seconds},
                     {"began_upright", row.began_upright},
                     {"upright", row.upright},
                     {"ever_upright", row.ever_upright},
                     {"diverged", row.diverged},
                     {"end_height_share", Number(row.end_height)},
                     {"root_distance_m", Number(row.root_distance)},
                     {"foot_skate_m_per_s", Number(row.foot_skate)}});
  }
  return array;
}

Json DiversityObject(const metrics::DiversityFigures& diversity) {
  if (diversity.pairs == 0) return nullptr;
  return {{"pairs", diversity.pairs},
          {"over_time_m", diversity.over_time_m},
          {"final_pose_m", diversity.final_m},
          {"final_root_m", diversity.final_root_m}};
}

Json FiguresObject(const SampleFigures& figures) {
  Json object = {
      {"name", figures.name},
      {"noise", figures.noise ? Json(*figures.noise) : Json(nullptr)},
      {"samples", figures.samples},
      {"starts", figures.starts},
      {"diverged", figures.diverged},
      {"began_upright", figures.began_upright},
      {"upright_share", Number(figures.upright_share)},
      {"got_up_share", Number(figures.got_up_share)},
      {"stuck_share", Number(figures.stuck_share)},
      {"diversity", DiversityObject(figures.diversity)},
      {"foot_skate_m_per_s", SkateNumber(figures.skate)},
      {"foot_contacts", figures.skate.contacts},
      {"root_speed_m_per_s", figures.energy.root_speed_m_per_s()},
      {"joint_speed_rad_per_s", figures.energy.joint_speed_rad_per_s()},
      {"acceleration_m_per_s2", figures.energy.acceleration_m_per_s2()},
      {"latent", LatentObject(figures.latent)},
      {"latent_mean", LatentObject(figures.latent_mean)}};
  if (figures.transitions) {
    object["transitions"] =
        TransitionsObject(*figures.transitions, figures.all_transitions);
    object["coverage_by_threshold"] = Curve(figures.coverage_curve);
    object["student_coverage"] = Number(figures.student_coverage);
  }
  object["rows"] = Rows(figures.rows);
  return object;
}

std::string StudentDefinition(const SamplingSource& source) {
  return absl::StrCat(
      "transitions of the policy that tracks the clips, in the world of "
      "evaluations: ",
      source.student_randomised ? "randomised as its recipe says"
                                : "not randomised",
      ", each piece ends where it fails; samples move in the same physics and "
      "actuator model, never randomised, and do not end");
}

Json Definitions(const SamplingSource& source) {
  return {
      {"upright", absl::StrFormat("%s at %g of its standing height or above",
                                  source.upright_body, kUprightShare)},
      {"upright_share",
       "of the samples that began upright, those upright at "
       "the end; diverged ones are not"},
      {"got_up_share", "of the samples that did not, those upright at the end"},
      {"stuck_share", "of the samples that did not, those upright in no frame"},
      {"diversity",
       "over pairs of samples of one start: mean distance of "
       "tracked bodies, relative to the root in its heading "
       "frame, over time and at the end; of the roots at the end"},
      {"foot_skate_m_per_s",
       "mean slide of feet that touch the floor (sim/metrics/foot_skate.h); "
       "null: none did"},
      {"acceleration_m_per_s2", "mean second difference of body positions"},
      {"latent",
       "of what was decoded: mean |z_t - z_t-1|, spread of all z, "
       "and the ratio of both; latent_mean: of the prior's means, and for the "
       "student of its encoder's"},
      {"transitions",
       "features of two consecutive states, the start apart: SELF_JOINT_SPACE "
       "of sim/world/observation.h, each standardised over the library, by 0.1 "
       "of its unit (m, rad, m/s, rad/s) where it varies less than that, which "
       "the paper does not say; distance: "
       "root mean square of the differences to the nearest library transition, "
       "mean over generated ones; squared_distance: equation 8 of Bae et al. "
       "2025, over all generated ones, and, as they do, over those within the "
       "threshold (null: none is); coverage: share of library transitions that "
       "a generated one lies "
       "within the threshold of; matched_share: that are the nearest of a "
       "generated one; far_share: generated ones beyond the threshold"},
      {"student", StudentDefinition(source)},
      {"student_coverage",
       "of the library transitions that the policy covers "
       "when it tracks the clips, the share covered here"},
      {"zero noise, zero action",
       "depend on the start alone: one sample of each start"}};
}

std::string Percent(double share) {
  return std::isfinite(share) ? absl::StrFormat("%.1f", 100 * share) : "-";
}

std::string Fixed(double value, bool known) {
  return known ? absl::StrFormat("%.3f", value) : "-";
}

}  // namespace

std::string SamplingJson(const SamplingSource& source,
                         const LibraryTransitions* library,
                         const std::vector<SampleFigures>& figures) {
  Json json = {{"bundle", source.bundle},
               {"manifest_sha256", source.manifest_sha256},
               {"character", source.character},
               {"start", source.start},
               {"seconds", source.seconds},
               {"seed", source.seed},
               {"control_hz", source.control_hz},
               {"standing_height_m", source.standing_height}};
  if (library != nullptr) {
    json["library"] = {
        {"motions", source.motions},
        {"sha256", source.library_sha256},
        {"transitions", library->rows.rows()},
        {"transitions_all", library->all},
        {"features", source.features},
        {"threshold", source.threshold},
        {"foot_skate_m_per_s", SkateNumber(library->skate)},
        {"root_speed_m_per_s", library->energy.root_speed_m_per_s()},
        {"joint_speed_rad_per_s", library->energy.joint_speed_rad_per_s()},
        {"acceleration_m_per_s2", library->energy.acceleration_m_per_s2()}};
    if (library->student) {
      json["student"] = TransitionsObject(
          metrics::SummariseMatch(*library->student, source.features,
                                  source.threshold),
          library->student_all);
      json["student"]["coverage_by_threshold"] =
          Curve(CoverageCurve(*library->student));
      json["student"]["latent_mean"] = LatentObject(library->student_latent);
    }
  }
  json["definitions"] = Definitions(source);
  json["ways"] = Json::array();
  for (const SampleFigures& one : figures) {
    json["ways"].push_back(FiguresObject(one));
  }
  // Paths are bytes, as they were typed.
  return json.dump(1, ' ', /*ensure_ascii=*/false,
                   Json::error_handler_t::replace) +
         "\n";
}

std::string SamplingTable(const std::vector<SampleFigures>& figures) {
  std::string table = absl::StrFormat(
      kColumns, "", "samples", "upright %", "got up %", "stuck %", "diverse m",
      "final m", "cover %", "student %", "distance", "skate m/s", "dz mean");
  for (const SampleFigures& one : figures) {
    const bool compared = one.transitions.has_value();
    absl::StrAppendFormat(
        &table, kColumns, one.name, absl::StrCat(one.samples),
        Percent(one.upright_share), Percent(one.got_up_share),
        Percent(one.stuck_share),
        Fixed(one.diversity.over_time_m, one.diversity.pairs > 0),
        Fixed(one.diversity.final_m, one.diversity.pairs > 0),
        compared ? Percent(one.transitions->coverage) : "-",
        Percent(one.student_coverage),
        Fixed(compared ? one.transitions->distance : 0, compared),
        Fixed(one.skate.mean_m_per_s(), one.skate.contacts > 0),
        Fixed(one.latent_mean.step, one.latent_mean.steps > 0));
  }
  return table;
}

}  // namespace sinew::sampling
