#include "sim/world/start.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::world {
namespace {

// Indices of the draws under one key; 0 was used once.
enum DrawIndex : uint64_t { kBin = 1, kFrame = 2 };

absl::Status CheckBin(const motion::Library& library,
                      const v1::CurriculumTable::Bin& bin, int index) {
  if (bin.clip() < 0 || bin.clip() >= library.num_clips()) {
    return absl::InvalidArgumentError(
        absl::StrCat("curriculum.bins[", index, "].clip: expected 0 to ",
                     library.num_clips() - 1, ", found ", bin.clip()));
  }
  const v1::ClipInfo& clip = library.clip(bin.clip());
  const int64_t end = int64_t{bin.first_frame()} + bin.num_frames();
  if (bin.first_frame() < 0 || bin.num_frames() < 1 ||
      end > clip.num_frames() || bin.first_frame() >= NumStartFrames(clip)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "curriculum.bins[", index, "]: expected frames within 0 to ",
        clip.num_frames(), " of clip ", clip.name(), " with one to start at, ",
        "found ", bin.first_frame(), " to ", end));
  }
  if (clip.left_out()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "curriculum.bins[", index, "].clip: expected one to train on, found ",
        clip.name(), ", which is left out"));
  }
  if (!(bin.probability() >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "curriculum.bins[", index, "].probability: expected >= 0, found ",
        bin.probability()));
  }
  return absl::OkStatus();
}

}  // namespace

bool IsDrawn(const v1::Start& recipe, const v1::ClipInfo& clip) {
  const auto& only = recipe.only_clips();
  return !clip.left_out() &&
         (only.empty() || recipe.other_clips_share() > 0 ||
          std::find(only.begin(), only.end(), clip.name()) != only.end());
}

int64_t NumStartFrames(const v1::ClipInfo& clip) {
  return clip.loops() ? clip.num_frames() : clip.num_frames() - 1;
}

absl::StatusOr<StartTable> StartTable::Create(
    const v1::Start& recipe, const motion::Library& library,
    const v1::CurriculumTable& curriculum) {
  StartTable table;
  int64_t end = 0;
  for (int c = 0; c < library.num_clips(); ++c) {
    const v1::ClipInfo& clip = library.clip(c);
    end += IsDrawn(recipe, clip) ? NumStartFrames(clip) : 0;
    table.ends_.push_back(end);
  }
  const bool uniform = (recipe.rule() == v1::Start::RULE_UNSPECIFIED ||
                        recipe.rule() == v1::Start::RULE_UNIFORM) &&
                       recipe.other_clips_share() == 0;
  if (!uniform && curriculum.bins_size() > 0) {
    SINEW_RETURN_IF_ERROR(table.AddBins(library, curriculum));
  }
  return table;
}

absl::Status StartTable::AddBins(const motion::Library& library,
                                 const v1::CurriculumTable& curriculum) {
  double sum = 0;
  for (int i = 0; i < curriculum.bins_size(); ++i) {
    const v1::CurriculumTable::Bin& bin = curriculum.bins(i);
    SINEW_RETURN_IF_ERROR(CheckBin(library, bin, i));
    sum += bin.probability();
    const int64_t startable = std::min<int64_t>(
        bin.num_frames(),
        NumStartFrames(library.clip(bin.clip())) - bin.first_frame());
    if (bin.probability() > 0) {
      bins_.push_back({.end = sum,
                       .clip = bin.clip(),
                       .first_frame = bin.first_frame(),
                       .num_frames = static_cast<int32_t>(startable)});
    }
  }
  if (!(std::abs(sum - 1) <= 1e-9)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "curriculum.bins: expected probabilities that sum to 1, found ", sum));
  }
  return absl::OkStatus();
}

StartFrame StartTable::Draw(uint64_t seed, uint64_t environment,
                            uint64_t episode) const {
  const RandomKey key{.seed = seed,
                      .environment = environment,
                      .episode = episode,
                      .step = 0,
                      .purpose = RandomPurpose::kStart};
  if (bins_.empty()) {
    const auto index = static_cast<int64_t>(
        UniformInt(key, static_cast<uint64_t>(num_frames()), kFrame));
    const auto clip = std::upper_bound(ends_.begin(), ends_.end(), index);
    const int64_t first = clip == ends_.begin() ? 0 : *(clip - 1);
    return {.clip = static_cast<int32_t>(clip - ends_.begin()),
            .frame = static_cast<int32_t>(index - first)};
  }
  const double point = Uniform(key, kBin) * bins_.back().end;
  auto bin = std::upper_bound(
      bins_.begin(), bins_.end(), point,
      [](double value, const Bin& candidate) { return value < candidate.end; });
  if (bin == bins_.end()) --bin;
  const uint64_t offset =
      UniformInt(key, static_cast<uint64_t>(bin->num_frames), kFrame);
  return {.clip = bin->clip,
          .frame = bin->first_frame + static_cast<int32_t>(offset)};
}

}  // namespace sinew::world
