#include "tools/report/curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "common/json_fields.h"

namespace sinew::report {
namespace {

constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

// Where a point lies: the last row counts.
constexpr std::array<const char*, 4> kPositions = {"iteration", "wall_s",
                                                   "train_s", "samples"};

// Copied as they are.
constexpr std::array<const char*, 15> kValues = {"reward",
                                                 "episode_steps",
                                                 "kl",
                                                 "clip_fraction",
                                                 "policy_loss",
                                                 "value_loss",
                                                 "epochs",
                                                 "policy_gradient_norm",
                                                 "value_gradient_norm",
                                                 "explained_variance",
                                                 "policy_learning_rate",
                                                 "value_learning_rate",
                                                 "std_factor",
                                                 "policy_lag",
                                                 "diverged"};

constexpr std::array<const char*, 4> kRewardTerms = {
    "reward_position", "reward_rotation", "reward_linear", "reward_angular"};

// Of the object "curriculum" of a row, by their names there.
constexpr std::array<const char*, 9> kCurriculumValues = {
    "entropy_share",        "floor_share",  "largest_clip_share",
    "clips_of_half",        "failure_rate", "hardest_share",
    "hardest_failure_rate", "hard_clips",   "worst_success"};

// Of the object "distillation" of a row, by their names there.
constexpr std::array<const char*, 5> kDistillationValues = {
    "action_loss", "latent_kl", "continuity_loss", "kl_weight", "memory_rows"};

double Value(const Json& row, const std::string& name) {
  return NumberAt(row, {name}, kAbsent);
}

double RewardTerm(const Json& row, size_t term) {
  const auto it = row.find("reward_terms");
  if (it == row.end() || !it->is_array() || it->size() <= term ||
      !(*it)[term].is_number()) {
    return kAbsent;
  }
  return (*it)[term].get<double>();
}

double FailShare(const Json& row) {
  const double episodes = Value(row, "episodes");
  return episodes > 0 ? Value(row, "failed_episodes") / episodes : kAbsent;
}

// null stands for "not there": JSON has no NaN.
Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// Rows first .. last of one point.
struct Bucket {
  const std::vector<Json>& rows;
  size_t first, last;

  template <typename Function>
  Json Mean(const Function& value_of) const {
    double sum = 0;
    int count = 0;
    for (size_t i = first; i <= last; ++i) {
      const double value = value_of(rows[i]);
      if (!std::isfinite(value)) continue;
      sum += value;
      ++count;
    }
    return count > 0 ? Number(sum / count) : Json(nullptr);
  }

  // Over the rows of the bucket and the step that leads into it.
  Json SamplesPerSecond() const {
    const auto difference = [&](const char* name) {
      return Value(rows[last], name) -
             (first > 0 ? Value(rows[first - 1], name) : 0);
    };
    const double seconds = difference("wall_s");
    return seconds > 0 ? Number(difference("samples") / seconds)
                       : Json(nullptr);
  }
};

void RemoveEmpty(Json* columns) {
  for (auto it = columns->begin(); it != columns->end();) {
    const bool empty = std::all_of(it->begin(), it->end(),
                                   [](const Json& v) { return v.is_null(); });
    it = empty ? columns->erase(it) : std::next(it);
  }
}

// Columns of at most kMaxPoints points: where each lies, and what
// add(bucket, columns) makes of its rows.
template <typename Add>
Json Thinned(const std::vector<Json>& rows, const Add& add) {
  Json columns = Json::object();
  const size_t width = (rows.size() + kMaxPoints - 1) / kMaxPoints;
  for (size_t first = 0; first < rows.size(); first += width) {
    const Bucket bucket{rows, first, std::min(first + width, rows.size()) - 1};
    for (const char* name : kPositions) {
      columns[name].push_back(Number(Value(rows[bucket.last], name)));
    }
    add(bucket, columns);
  }
  RemoveEmpty(&columns);
  return columns;
}

double CurriculumValue(const Json& row, const char* name) {
  const bool known = std::string_view(name) != "worst_success" ||
                     NumberAt(row, {"curriculum", "evaluated_clips"}) > 0;
  return known ? NumberAt(row, {"curriculum", name}, kAbsent) : kAbsent;
}

}  // namespace

Json TrainingCurves(const std::vector<Json>& rows) {
  return Thinned(rows, [](const Bucket& bucket, Json& columns) {
    for (const char* name : kValues) {
      columns[name].push_back(
          bucket.Mean([&](const Json& row) { return Value(row, name); }));
    }
    for (size_t term = 0; term < kRewardTerms.size(); ++term) {
      columns[kRewardTerms[term]].push_back(
          bucket.Mean([&](const Json& row) { return RewardTerm(row, term); }));
    }
    for (const char* name : kDistillationValues) {
      // Of a latent that PPO learns, latent_kl is the row's own.
      columns[name].push_back(bucket.Mean([&](const Json& row) {
        return NumberAt(row, {"distillation", name}, Value(row, name));
      }));
    }
    columns["action_error_mrad"].push_back(bucket.Mean([](const Json& row) {
      return 1000 *
             NumberAt(row, {"distillation", "action_error_rad"}, kAbsent);
    }));
    columns["tracking_mm"].push_back(bucket.Mean(
        [](const Json& row) { return 1000 * Value(row, "body_distance_m"); }));
    columns["fail_share"].push_back(bucket.Mean(FailShare));
    columns["samples_per_s"].push_back(bucket.SamplesPerSecond());
  });
}

Json CurriculumCurves(const std::vector<Json>& rows) {
  // One bin has all the starts, always.
  if (rows.empty() || NumberAt(rows.back(), {"curriculum", "bins"}) < 2) {
    return Json::object();
  }
  return Thinned(rows, [](const Bucket& bucket, Json& columns) {
    for (const char* name : kCurriculumValues) {
      columns[name].push_back(bucket.Mean(
          [&](const Json& row) { return CurriculumValue(row, name); }));
    }
  });
}

Json EvaluationCurves(const std::vector<Json>& rows) {
  Json columns = Json::object();
  for (const Json& row : rows) {
    const auto eval = row.find("eval");
    if (eval == row.end() || !eval->is_object()) continue;
    for (const char* name : kPositions) {
      columns[name].push_back(Number(Value(row, name)));
    }
    const double starts = Value(*eval, "starts");
    columns["succeeded_share"].push_back(Number(
        starts > 0 ? Value(*eval, "succeeded_starts") / starts : kAbsent));
    const double left_out = NumberAt(*eval, {"left_out", "starts"});
    columns["left_out_succeeded_share"].push_back(Number(
        left_out > 0
            ? NumberAt(*eval, {"left_out", "succeeded_starts"}) / left_out
            : kAbsent));
    for (const char* name :
         {"survived_share", "e_g_mpjpe_mm", "e_mpjpe_mm", "e_vel", "e_acc"}) {
      columns[name].push_back(Number(Value(*eval, name)));
    }
  }
  RemoveEmpty(&columns);
  return columns;
}

}  // namespace sinew::report
