#include "tools/sampling/sample_figures.h"

#include <algorithm>
#include <cmath>

#include "common/status_macros.h"

namespace sinew::sampling {
namespace {

bool IsUpright(const BodyLaw& law, double height) {
  return height >= kUprightShare * law.standing_height();
}

SampleRow MakeRow(const BodyLaw& law, absl::Span<const SampleStart> starts,
                  const SampleMotion& motion) {
  const std::vector<float>& root = motion.path.root;
  SampleRow row;
  row.start = starts[static_cast<size_t>(motion.start)].name;
  row.seconds = (motion.frames() - 1) / law.control_hz();
  row.began_upright = IsUpright(law, motion.upright_height.front());
  row.diverged = motion.diverged;
  row.upright =
      !motion.diverged && IsUpright(law, motion.upright_height.back());
  row.ever_upright =
      std::any_of(motion.upright_height.begin(), motion.upright_height.end(),
                  [&](double height) { return IsUpright(law, height); });
  row.end_height = motion.upright_height.back() / law.standing_height();
  row.root_distance =
      std::hypot(static_cast<double>(root[root.size() - 2]) - root[0],
                 static_cast<double>(root[root.size() - 1]) - root[1]);
  if (motion.skate.contacts > 0) row.foot_skate = motion.skate.mean_m_per_s();
  return row;
}

void CountRows(SampleFigures& figures) {
  int stayed = 0, got_up = 0, stuck = 0;
  for (const SampleRow& row : figures.rows) {
    figures.diverged += row.diverged ? 1 : 0;
    figures.began_upright += row.began_upright ? 1 : 0;
    stayed += row.began_upright && row.upright ? 1 : 0;
    got_up += !row.began_upright && row.upright ? 1 : 0;
    stuck += row.ever_upright ? 0 : 1;
  }
  const int fallen = figures.samples - figures.began_upright;
  if (figures.began_upright > 0) {
    figures.upright_share = static_cast<double>(stayed) / figures.began_upright;
  }
  if (fallen > 0) {
    figures.got_up_share = static_cast<double>(got_up) / fallen;
    figures.stuck_share = static_cast<double>(stuck) / fallen;
  }
}

absl::StatusOr<metrics::DiversityFigures> Diversity(
    absl::Span<const SampleMotion> motions, const StopToken& stop) {
  metrics::DiversityMeter meter;
  for (size_t first = 0; first < motions.size();) {
    std::vector<metrics::PosePath> group;
    size_t i = first;
    for (; i < motions.size() && motions[i].start == motions[first].start;
         ++i) {
      group.push_back(motions[i].path);
    }
    SINEW_RETURN_IF_ERROR(meter.AddGroup(group, stop));
    first = i;
  }
  return meter.figures();
}

absl::Status Compare(const Sampler& sampler,
                     absl::Span<const SampleMotion> motions,
                     const LibraryTransitions& library,
                     const FigureOptions& options, const StopToken& stop,
                     SampleFigures& figures) {
  for (const SampleMotion& motion : motions) {
    figures.all_transitions += std::max<int64_t>(0, motion.frames() - 2);
  }
  metrics::TransitionSet set(sampler.num_features(), figures.all_transitions,
                             options.most_transitions);
  for (const SampleMotion& motion : motions) {
    set.AddMotion(absl::MakeConstSpan(motion.states)
                      .subspan(static_cast<size_t>(sampler.num_features())));
  }
  if (set.size() == 0) return absl::OkStatus();  // none took two steps
  SINEW_ASSIGN_OR_RETURN(
      const metrics::TransitionMatch match,
      metrics::MatchTransitions(
          library.rows, metrics::Standardised(set, library.standardisation),
          options.threads, stop));
  figures.transitions =
      metrics::SummariseMatch(match, sampler.num_features(), options.threshold);
  figures.coverage_curve = CoverageCurve(match);
  if (library.student) {
    figures.student_coverage =
        metrics::SharedCoverage(match, *library.student, options.threshold);
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<double> CoverageCurve(const metrics::TransitionMatch& match) {
  std::vector<double> curve;
  for (const double threshold : kCoverageThresholds) {
    const auto within = std::count_if(
        match.library_distance.begin(), match.library_distance.end(),
        [&](double distance) { return distance <= threshold; });
    curve.push_back(static_cast<double>(within) /
                    static_cast<double>(match.library_distance.size()));
  }
  return curve;
}

absl::StatusOr<SampleFigures> MeasureSamples(
    const Sampler& sampler, absl::Span<const SampleStart> starts,
    absl::Span<const SampleMotion> motions, const LibraryTransitions* library,
    const FigureOptions& options, const StopToken& stop) {
  SampleFigures figures;
  figures.samples = static_cast<int>(motions.size());
  figures.starts = static_cast<int>(starts.size());
  metrics::LatentMeter latent(sampler.latent_width());
  metrics::LatentMeter latent_mean(sampler.latent_width());
  for (const SampleMotion& motion : motions) {
    figures.rows.push_back(MakeRow(sampler.law(), starts, motion));
    figures.skate.Add(motion.skate);
    figures.energy.Add(motion.energy);
    latent.AddMotion(motion.latent);
    latent_mean.AddMotion(motion.latent_mean);
  }
  CountRows(figures);
  SINEW_ASSIGN_OR_RETURN(figures.diversity, Diversity(motions, stop));
  figures.latent = latent.figures();
  figures.latent_mean = latent_mean.figures();
  if (library != nullptr) {
    SINEW_RETURN_IF_ERROR(
        Compare(sampler, motions, *library, options, stop, figures));
  }
  return figures;
}

}  // namespace sinew::sampling
