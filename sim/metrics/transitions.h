#ifndef SINEW_SIM_METRICS_TRANSITIONS_H_
#define SINEW_SIM_METRICS_TRANSITIONS_H_

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/stop.h"

namespace sinew::metrics {

// How near generated motion is to a library, and how much of the library it
// comes near to: distance and coverage of transitions, after equation 8 of the
// hybrid latent representation (Bae et al. 2025).
//
// A state s is F features; which ones the caller says. A transition (s, s') is
// two consecutive states of one motion. With each feature standardised by its
// mean and standard deviation over the library's states, the distance between
// transitions a and b is
//
//   d(a, b) = sqrt((|s_a - s_b|^2 + |s'_a - s'_b|^2) / (2 F))
//
// the root mean square of the 2 F differences, in standard deviations. The
// paper's number is its square times 2 F; which transition is nearest is the
// same. Two independent library transitions are sqrt(2) apart on the average,
// the mean transition and another 1.
//
// For generated transitions G, library transitions L and a threshold theta:
//
//   distance   mean over g in G of min over l of d(g, l)
//   squared    mean over g in G of min over l of 2 F d(g, l)^2
//   squared_within   the same over those g with d <= theta alone (the paper's
//              distance, over its valid transitions); NaN if there are none
//   far        share of G with min over l of d(g, l) > theta
//   coverage   share of L with min over g of d(g, l) <= theta
//   matched    share of L that is the nearest one of some g (the paper's
//              coverage; ties to the lowest index)
//
// Coverage and matched grow with |G|: whoever states them states |G|, |L| and
// theta.

using FeatureRows =
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Smallest standard deviation of a feature, in its unit (m, rad, m/s, rad/s):
// one that hardly varies in the library would count without bound. With 0.01 a
// student that walks a clip at 28 mm was 7 deviations from it, with 0.1 it is
// 1.5.
inline constexpr double kSmallestDeviation = 0.1;

// Transitions of motions that come one after another, evenly thinned: of those
// that were announced, number k is kept where floor(k most / announced)
// changes, so that at most `most` are kept however many there are.
//
// Thread-safety: one caller. Ownership: owns its rows. Blocking: never.
// Errors: none; CHECKs rows of another width. Numbers must be finite.
class TransitionSet {
 public:
  // `announced` >= 0 transitions will come (fewer may), `most` >= 1 are kept.
  TransitionSet(int features, int64_t announced, int64_t most);

  // States [frames, F] of one motion, row-major; its frames - 1 transitions.
  void AddMotion(absl::Span<const float> states);

  int features() const { return features_; }
  int64_t size() const {
    return static_cast<int64_t>(rows_.size()) / (2 * features_);
  }
  // All that were added, kept or not.
  int64_t seen() const { return seen_; }
  // [size(), 2 F]: s, then s'.
  Eigen::Map<const FeatureRows> rows() const {
    return {rows_.data(), size(), 2 * features_};
  }

 private:
  const int features_;
  const int64_t announced_, most_;
  int64_t seen_ = 0;
  std::vector<float> rows_;
};

// Mean and 1 / max(standard deviation, kSmallestDeviation) of each feature.
struct Standardisation {
  Eigen::RowVectorXf mean, inverse_deviation;  // [F]
};

// Over all states of the transitions. Precondition: there is one.
Standardisation Standardise(const TransitionSet& library);

// [N, 2 F] standardised rows.
FeatureRows Standardised(const TransitionSet& set,
                         const Standardisation& standardisation);

// Nearest neighbours both ways.
struct TransitionMatch {
  std::vector<double> generated_distance;  // [G] d to the nearest of L
  std::vector<int64_t> generated_nearest;  // [G] index into L
  std::vector<double> library_distance;    // [L] d to the nearest of G
};

// Of standardised rows [L, 2 F] and [G, 2 F]; none may be empty. By brute
// force: L G 4 F operations, shared out among `threads` threads; the same bits
// for any number of threads. Blocking: computes, or until the next block of
// 256 x 1024 pairs after a request to stop. Errors: CANCELLED.
absl::StatusOr<TransitionMatch> MatchTransitions(const FeatureRows& library,
                                                 const FeatureRows& generated,
                                                 int threads,
                                                 const StopToken& stop);

struct TransitionFigures {
  int64_t library = 0;    // |L|
  int64_t generated = 0;  // |G|
  double distance = 0;
  double squared = 0;
  double squared_within = std::numeric_limits<double>::quiet_NaN();
  double far_share = 0;
  double coverage = 0;
  double matched = 0;
};

// `features` is F.
TransitionFigures SummariseMatch(const TransitionMatch& match, int features,
                                 double threshold);

// Of the library transitions that `other` covers (its library_distance within
// the threshold), the share that `match` covers too; NaN if there are none.
double SharedCoverage(const TransitionMatch& match,
                      const TransitionMatch& other, double threshold);

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_TRANSITIONS_H_
