#include "tools/evaluation/error_profile.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace sinew::evaluation {

ErrorProfile::ErrorProfile(const character::Character& character,
                           const motion::Library& library, int clip)
    : character_(&character),
      library_(&library),
      clip_(clip),
      bins_(static_cast<int>(
          std::min<int64_t>(library.clip(clip).num_frames(), kMaxBins))),
      reference_(std::make_unique<motion::ReferenceFrame>(library)),
      sum_mm_(character.tracked().size() * static_cast<size_t>(bins_), 0.0),
      visits_(static_cast<size_t>(bins_), 0) {}

void ErrorProfile::Add(const v1::EvaluationStart& start, int frame,
                       const mjData& data) {
  SINEW_DCHECK(start.clip() == clip_);
  const int64_t at = int64_t{start.start_frame()} + frame;
  const int64_t frames = library_->clip(clip_).num_frames();
  const int64_t phase =
      library_->clip(clip_).loops() ? at % frames : std::min(at, frames - 1);
  const auto bin = static_cast<size_t>(phase * bins_ / frames);
  reference_->Load(clip_, at);
  const float* positions = reference_->view().body_position;
  for (size_t b = 0; b < character_->tracked().size(); ++b) {
    const int column = character_->tracked()[b];
    // Column 0 of a library is body 1 of the model.
    const mjtNum* body = data.xpos + 3 * (column + 1);
    const float* reference = positions + 3 * column;
    sum_mm_[b * static_cast<size_t>(bins_) + bin] +=
        1000 * std::hypot(body[0] - reference[0], body[1] - reference[1],
                          body[2] - reference[2]);
  }
  ++visits_[bin];
}

void ErrorProfile::Merge(const ErrorProfile& other) {
  SINEW_CHECK(other.clip_ == clip_ && other.sum_mm_.size() == sum_mm_.size());
  for (size_t i = 0; i < sum_mm_.size(); ++i) sum_mm_[i] += other.sum_mm_[i];
  for (size_t i = 0; i < visits_.size(); ++i) visits_[i] += other.visits_[i];
}

double ErrorProfile::mean_mm(int body, int bin) const {
  const int64_t visits = visits_[bin];
  return visits == 0 ? 0
                     : sum_mm_[static_cast<size_t>(body) * bins_ + bin] /
                           static_cast<double>(visits);
}

double ErrorProfile::sum_mm(int body) const {
  double sum = 0;
  for (int bin = 0; bin < bins_; ++bin) {
    sum += sum_mm_[static_cast<size_t>(body) * bins_ + bin];
  }
  return sum;
}

}  // namespace sinew::evaluation
