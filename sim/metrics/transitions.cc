#include "sim/metrics/transitions.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "common/check.h"

namespace sinew::metrics {
namespace {

using Eigen::Index;

constexpr Index kGeneratedBlock = 256;
constexpr Index kLibraryBlock = 1024;

// Nearest so far; of equally near ones the lowest index, so that the order in
// which candidates come does not count.
struct Nearest {
  float squared = std::numeric_limits<float>::infinity();
  int64_t index = std::numeric_limits<int64_t>::max();

  void Offer(float value, int64_t of) {
    if (value < squared || (value == squared && of < index)) {
      squared = value;
      index = of;
    }
  }
};

// One call of MatchTransitions: threads take the next block of generated rows
// until none is left.
class Matching {
 public:
  Matching(const FeatureRows& library, const FeatureRows& generated,
           const StopToken& stop)
      : library_(library),
        generated_(generated),
        stop_(stop),
        library_norm_(library.rowwise().squaredNorm()),
        generated_norm_(generated.rowwise().squaredNorm()),
        of_generated_(static_cast<size_t>(generated.rows())) {}

  Index num_blocks() const {
    return (generated_.rows() + kGeneratedBlock - 1) / kGeneratedBlock;
  }
  const std::vector<Nearest>& of_generated() const { return of_generated_; }

  // The body of one thread. `of_library` [L] is its own.
  void Work(std::vector<Nearest>& of_library) {
    FeatureRows product;
    for (Index block = next_++; block < num_blocks(); block = next_++) {
      const Index first = block * kGeneratedBlock;
      const Index rows = std::min(kGeneratedBlock, generated_.rows() - first);
      for (Index column = 0; column < library_.rows();
           column += kLibraryBlock) {
        if (stop_.stop_requested()) return;
        const Index columns = std::min(kLibraryBlock, library_.rows() - column);
        product.noalias() = generated_.middleRows(first, rows) *
                            library_.middleRows(column, columns).transpose();
        Compare(product, first, column, of_library);
      }
    }
  }

 private:
  void Compare(const FeatureRows& product, Index first, Index column,
               std::vector<Nearest>& of_library) {
    for (Index i = 0; i < product.rows(); ++i) {
      const Index g = first + i;
      Nearest& nearest = of_generated_[static_cast<size_t>(g)];
      for (Index j = 0; j < product.cols(); ++j) {
        const Index l = column + j;
        const float squared =
            generated_norm_[g] + library_norm_[l] - 2 * product(i, j);
        nearest.Offer(squared, l);
        of_library[static_cast<size_t>(l)].Offer(squared, g);
      }
    }
  }

  const FeatureRows& library_;
  const FeatureRows& generated_;
  const StopToken stop_;
  const Eigen::VectorXf library_norm_, generated_norm_;
  std::atomic<Index> next_ = 0;
  // Every block writes elements of its own.
  std::vector<Nearest> of_generated_;
};

// d of two rows, exactly; what the product gives is off where they are alike.
double Distance(const FeatureRows& a, Index row, const FeatureRows& b,
                Index other) {
  return std::sqrt(
      (a.row(row).cast<double>() - b.row(other).cast<double>()).squaredNorm() /
      static_cast<double>(a.cols()));
}

bool Covered(double distance, double threshold) {
  return distance <= threshold;
}

}  // namespace

TransitionSet::TransitionSet(int features, int64_t announced, int64_t most)
    : features_(features), announced_(announced), most_(most) {
  SINEW_CHECK(features >= 1 && announced >= 0 && most >= 1);
}

void TransitionSet::AddMotion(absl::Span<const float> states) {
  const auto width = static_cast<size_t>(features_);
  SINEW_CHECK(states.size() % width == 0) << states.size() << " numbers";
  for (size_t at = 0; at + 2 * width <= states.size(); at += width) {
    const int64_t k = seen_++;
    if (announced_ > most_ &&
        (k + 1) * most_ / announced_ == k * most_ / announced_) {
      continue;
    }
    const absl::Span<const float> both = states.subspan(at, 2 * width);
    rows_.insert(rows_.end(), both.begin(), both.end());
  }
}

Standardisation Standardise(const TransitionSet& library) {
  SINEW_CHECK(library.size() > 0);
  // A state is the end of one transition and the beginning of the next:
  // counted twice, which changes neither mean nor deviation much.
  const int features = library.features();
  const Eigen::Map<const FeatureRows> states(library.rows().data(),
                                             2 * library.size(), features);
  const Eigen::RowVectorXd mean = states.cast<double>().colwise().mean();
  Eigen::RowVectorXd square = Eigen::RowVectorXd::Zero(features);
  for (Index i = 0; i < states.rows(); ++i) {
    square += (states.row(i).cast<double>() - mean).cwiseAbs2();
  }
  const Eigen::RowVectorXd deviation =
      (square / static_cast<double>(states.rows())).cwiseSqrt();
  return {
      .mean = mean.cast<float>(),
      .inverse_deviation =
          deviation.cwiseMax(kSmallestDeviation).cwiseInverse().cast<float>()};
}

FeatureRows Standardised(const TransitionSet& set,
                         const Standardisation& standardisation) {
  FeatureRows rows = set.rows();
  const int features = set.features();
  for (int half = 0; half < 2; ++half) {
    auto block = rows.middleCols(half * features, features);
    block.rowwise() -= standardisation.mean;
    block.array().rowwise() *= standardisation.inverse_deviation.array();
  }
  return rows;
}

absl::StatusOr<TransitionMatch> MatchTransitions(const FeatureRows& library,
                                                 const FeatureRows& generated,
                                                 int threads,
                                                 const StopToken& stop) {
  SINEW_CHECK(library.rows() > 0 && generated.rows() > 0 && threads >= 1);
  SINEW_CHECK(library.cols() == generated.cols());
  Matching matching(library, generated, stop);
  const auto count =
      static_cast<size_t>(std::min<Index>(threads, matching.num_blocks()));
  std::vector<std::vector<Nearest>> of_library(
      count, std::vector<Nearest>(static_cast<size_t>(library.rows())));
  {
    std::vector<std::jthread> joined;
    for (std::vector<Nearest>& own : of_library) {
      joined.emplace_back([&matching, &own] { matching.Work(own); });
    }
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("transitions: stopped before the end");
  }
  TransitionMatch match;
  for (size_t g = 0; g < matching.of_generated().size(); ++g) {
    const int64_t nearest = matching.of_generated()[g].index;
    match.generated_nearest.push_back(nearest);
    match.generated_distance.push_back(
        Distance(generated, static_cast<Index>(g), library, nearest));
  }
  for (size_t l = 0; l < static_cast<size_t>(library.rows()); ++l) {
    Nearest nearest;
    for (const std::vector<Nearest>& own : of_library) {
      nearest.Offer(own[l].squared, own[l].index);
    }
    match.library_distance.push_back(
        Distance(library, static_cast<Index>(l), generated, nearest.index));
  }
  return match;
}

TransitionFigures SummariseMatch(const TransitionMatch& match, int features,
                                 double threshold) {
  TransitionFigures figures;
  figures.library = static_cast<int64_t>(match.library_distance.size());
  figures.generated = static_cast<int64_t>(match.generated_distance.size());
  if (figures.library == 0 || figures.generated == 0) return figures;
  int64_t far = 0;
  double squared_within = 0;
  std::vector<bool> matched(match.library_distance.size());
  for (size_t g = 0; g < match.generated_distance.size(); ++g) {
    const double distance = match.generated_distance[g];
    figures.distance += distance;
    const double squared = 2 * features * distance * distance;
    const bool within = Covered(distance, threshold);
    figures.squared += squared;
    squared_within += within ? squared : 0;
    far += within ? 0 : 1;
    matched[static_cast<size_t>(match.generated_nearest[g])] = true;
  }
  const auto covered = std::count_if(
      match.library_distance.begin(), match.library_distance.end(),
      [&](double distance) { return Covered(distance, threshold); });
  const auto generated = static_cast<double>(figures.generated);
  const auto library = static_cast<double>(figures.library);
  figures.distance /= generated;
  figures.squared /= generated;
  if (far < figures.generated) {
    figures.squared_within =
        squared_within / static_cast<double>(figures.generated - far);
  }
  figures.far_share = static_cast<double>(far) / generated;
  figures.coverage = static_cast<double>(covered) / library;
  figures.matched =
      static_cast<double>(std::count(matched.begin(), matched.end(), true)) /
      library;
  return figures;
}

double SharedCoverage(const TransitionMatch& match,
                      const TransitionMatch& other, double threshold) {
  SINEW_CHECK(match.library_distance.size() == other.library_distance.size());
  int64_t both = 0, all = 0;
  for (size_t l = 0; l < match.library_distance.size(); ++l) {
    if (!Covered(other.library_distance[l], threshold)) continue;
    ++all;
    both += Covered(match.library_distance[l], threshold) ? 1 : 0;
  }
  if (all == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(both) / static_cast<double>(all);
}

}  // namespace sinew::metrics
