#include "tools/bench/distillation_figures.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "learner/distillation/distillation_networks.h"
#include "learner/distillation/student_networks.h"
#include "learner/torch/runtime.h"

namespace sinew::bench {
namespace {

using learner::DistillationNetworks;

// What a shard learns from.
struct MadeUpRows {
  MadeUpRows(int64_t count, const LearnerWidths& widths, int64_t latent_width)
      : observation(Draw(1, count * widths.observation)),
        noise(Draw(2, count * latent_width)),
        label(Draw(3, count * widths.action)),
        ones(count, 1.0F) {}

  static std::vector<float> Draw(uint64_t seed, int64_t size) {
    std::vector<float> values(size);
    FillNormal({.seed = seed}, absl::MakeSpan(values));
    return values;
  }

  DistillationNetworks::Rows View() const {
    return {.observation = observation,
            .noise = noise,
            .label = label,
            .valid = ones,
            .linked = ones};
  }

  std::vector<float> observation, noise, label, ones;
};

class Student {
 public:
  static absl::StatusOr<std::unique_ptr<Student>> Create(
      const v1::Recipe& recipe, const LearnerWidths& widths, bool bfloat16) {
    SINEW_ASSIGN_OR_RETURN(
        const learner::Student made,
        learner::MakeStudent(recipe, widths.observation,
                             widths.self_observation, widths.action));
    const v1::Distillation& settings = recipe.distillation();
    auto student = std::make_unique<Student>();
    student->shards_ = settings.shards();
    student->on_cuda_ = recipe.device() == "cuda";
    SINEW_ASSIGN_OR_RETURN(
        student->networks_,
        DistillationNetworks::Create(
            made.graph, made.weights,
            {.device = recipe.device(),
             .shards = settings.shards(),
             .shard_rows = settings.minibatch() / settings.shards(),
             .steps = recipe.rollouts().horizon(),
             .form = settings.form(),
             .bfloat16 = bfloat16,
             .action_scale = std::vector<double>(widths.action, 1)}));
    student->weights_ = {.kl = settings.kl_weight_final(),
                         .continuity = settings.continuity_weight(),
                         .row_scale = 1.0 / settings.minibatch(),
                         .pair_scale = 1.0 / settings.minibatch()};
    return student;
  }

  int64_t latent_width() const { return networks_->latent_width(); }
  double flops_per_row() const { return networks_->flops_per_row(); }

  // Seconds of one minibatch, every shard on `rows`.
  absl::StatusOr<double> Learn(const MadeUpRows& rows) {
    const double begin = Now();
    for (int shard = 0; shard < shards_; ++shard) {
      SINEW_RETURN_IF_ERROR(
          networks_->Gradient(shard, rows.View(), weights_).status());
    }
    SINEW_RETURN_IF_ERROR(networks_->SumGradients().status());
    SINEW_RETURN_IF_ERROR(
        networks_->Step(/*learning_rate=*/1e-4, /*gradient_scale=*/1));
    return Now() - begin;
  }

 private:
  // CPU seconds of this thread; on "cuda" seconds of the wall.
  double Now() const {
    if (!on_cuda_) return ThreadSeconds();
    return std::chrono::duration<double>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }

  std::unique_ptr<DistillationNetworks> networks_;
  DistillationNetworks::Weights weights_;
  int shards_ = 1;
  bool on_cuda_ = false;
};

absl::StatusOr<DistillationFigures> Measure(const v1::Recipe& recipe,
                                            const LearnerWidths& widths,
                                            int minibatches) {
  learner::UseOneThread();
  DistillationFigures figures;
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<Student> student,
                         Student::Create(recipe, widths, /*bfloat16=*/false));
  std::unique_ptr<Student> rounded;
  const absl::Status has_bfloat16 = learner::CheckBfloat16(
      learner::DetectCpu(), recipe.device(), "distillation.bfloat16");
  figures.bfloat16_reason = std::string(has_bfloat16.message());
  if (has_bfloat16.ok()) {
    SINEW_ASSIGN_OR_RETURN(rounded,
                           Student::Create(recipe, widths, /*bfloat16=*/true));
    figures.bfloat16_rows_per_s = 0;
  }
  const v1::Distillation& settings = recipe.distillation();
  const MadeUpRows rows(settings.minibatch() / settings.shards(), widths,
                        student->latent_width());
  const double count = settings.minibatch();
  for (int i = 0; i < minibatches; ++i) {
    SINEW_ASSIGN_OR_RETURN(const double seconds, student->Learn(rows));
    figures.rows_per_s = std::max(figures.rows_per_s, count / seconds);
    if (rounded == nullptr) continue;
    SINEW_ASSIGN_OR_RETURN(const double of_rounded, rounded->Learn(rows));
    figures.bfloat16_rows_per_s =
        std::max(*figures.bfloat16_rows_per_s, count / of_rounded);
  }
  figures.flops_per_s = student->flops_per_row() * figures.rows_per_s;
  if (rounded != nullptr) {
    figures.bfloat16_ratio = *figures.bfloat16_rows_per_s / figures.rows_per_s;
  }
  return figures;
}

}  // namespace

absl::StatusOr<DistillationFigures> MeasureDistillation(
    const v1::Recipe& recipe, const LearnerWidths& widths, int minibatches) {
  const v1::Recipe full = WithDefaults(recipe);
  if (!full.has_distillation()) {
    return absl::InvalidArgumentError(
        absl::StrCat("recipe ", full.name(),
                     ": expected distillation, found none to measure"));
  }
  absl::StatusOr<DistillationFigures> figures;
  // A thread of its own: its libtorch settings are for good.
  std::jthread([&] { figures = Measure(full, widths, minibatches); }).join();
  return figures;
}

}  // namespace sinew::bench
