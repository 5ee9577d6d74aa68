#include "tools/sampling/sample_starts.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/world/fallen_states.h"
#include "sim/world/tracking_task.h"
#include "tools/evaluation/subject.h"

namespace sinew::sampling {
namespace {

// A foot whose label is above this bears.
constexpr float kBears = 0.5F;

struct ClipFrame {
  int clip;
  int64_t frame;
};

bool IsStart(const BodyLaw& law, const motion::Library& library,
             StartKind::Kind kind, const motion::FrameView& frame) {
  // Column b of a library is model body b + 1.
  const float height = frame.body_position[3 * (law.upright_body() - 1) + 2];
  const float* velocity = frame.root_linear_velocity;
  return height >= kUprightShare * law.standing_height() &&
         std::any_of(frame.contact, frame.contact + library.num_feet(),
                     [](float label) { return label > kBears; }) &&
         (kind == StartKind::Kind::kClip ||
          std::hypot(velocity[0], velocity[1], velocity[2]) < kStandingSpeed);
}

std::vector<ClipFrame> StartFrames(const BodyLaw& law,
                                   const motion::Library& library,
                                   StartKind::Kind kind) {
  std::vector<ClipFrame> frames;
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    if (library.clip(clip).left_out()) continue;
    for (int64_t i = 0; i < library.clip(clip).num_frames(); ++i) {
      if (IsStart(law, library, kind, library.frame(clip, i))) {
        frames.push_back({.clip = clip, .frame = i});
      }
    }
  }
  return frames;
}

SampleStart ClipState(const BodyLaw& law, const motion::Library& library,
                      const ClipFrame& at) {
  const mjModel* model = law.character().model();
  const character::DataPtr data(mj_makeData(model));
  world::SetReferencePose(law.character(), library.frame(at.clip, at.frame),
                          data.get());
  return {.name = absl::StrFormat("%s at %.2f s", library.clip(at.clip).name(),
                                  static_cast<double>(at.frame) /
                                      library.manifest().frames_per_second()),
          .qpos = {data->qpos, data->qpos + model->nq},
          .qvel = {data->qvel, data->qvel + model->nv}};
}

absl::StatusOr<std::vector<SampleStart>> FromClips(
    const BodyLaw& law, const motion::Library& library, StartKind::Kind kind,
    int count, uint64_t seed, const StopToken& stop) {
  const bool stands = kind == StartKind::Kind::kStanding;
  const std::string flag =
      absl::StrCat("--start ", stands ? "standing" : "clip");
  const std::vector<ClipFrame> frames = StartFrames(law, library, kind);
  if (frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        flag, ": expected clips with an upright body on a foot",
        stands ? absl::StrCat(", slower than ", kStandingSpeed, " m/s") : "",
        ", found none"));
  }
  std::vector<SampleStart> starts;
  for (int i = 0; i < count; ++i) {
    if (stop.stop_requested()) {
      return absl::CancelledError(
          absl::StrCat(flag, ": stopped before its end"));
    }
    const RandomKey key = {.seed = seed,
                           .environment = static_cast<uint64_t>(i),
                           .purpose = RandomPurpose::kStart};
    starts.push_back(
        ClipState(law, library, frames[UniformInt(key, frames.size())]));
  }
  return starts;
}

absl::StatusOr<std::vector<SampleStart>> FromFloor(const BodyLaw& law,
                                                   int count,
                                                   const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const world::FallenStates fallen,
                         world::FallenStates::MakeForEvaluation(
                             law.character(), law.recipe(), count, stop));
  std::vector<SampleStart> starts;
  for (int i = 0; i < count; ++i) {
    const absl::Span<const double> qpos = fallen.qpos(i);
    starts.push_back(
        {.name = absl::StrCat("fallen ", i),
         .qpos = {qpos.begin(), qpos.end()},
         .qvel = std::vector<double>(law.character().model()->nv)});
  }
  return starts;
}

absl::StatusOr<std::vector<SampleStart>> FromGiven(
    const BodyLaw& law, const motion::Library& library, const StartKind& kind) {
  SINEW_ASSIGN_OR_RETURN(const int clip,
                         evaluation::FindClip(library, kind.clip));
  const double rate = library.manifest().frames_per_second();
  const int64_t last = library.clip(clip).num_frames() - 1;
  const double frame = std::round(kind.seconds * rate);
  if (!(frame <= static_cast<double>(last))) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--start %s: expected at most %.2f s, found %g", kind.clip,
        static_cast<double>(last) / rate, kind.seconds));
  }
  return std::vector<SampleStart>{ClipState(
      law, library, {.clip = clip, .frame = static_cast<int64_t>(frame)})};
}

}  // namespace

absl::StatusOr<StartKind> ParseStart(absl::string_view text) {
  if (text == "clip") return StartKind{.kind = StartKind::Kind::kClip};
  if (text == "standing") return StartKind{.kind = StartKind::Kind::kStanding};
  if (text == "fallen") return StartKind{.kind = StartKind::Kind::kFallen};
  StartKind kind = {.kind = StartKind::Kind::kGiven};
  const size_t colon = text.rfind(':');
  if (colon == absl::string_view::npos || colon == 0 ||
      !absl::SimpleAtod(text.substr(colon + 1), &kind.seconds) ||
      !std::isfinite(kind.seconds) || kind.seconds < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--start: expected clip, standing, fallen or CLIP:SECONDS, found \"",
        text, "\""));
  }
  kind.clip = std::string(text.substr(0, colon));
  return kind;
}

absl::StatusOr<std::vector<SampleStart>> MakeStarts(
    const BodyLaw& law, const motion::Library* library, const StartKind& kind,
    int count, uint64_t seed, const StopToken& stop) {
  if (kind.kind == StartKind::Kind::kFallen) {
    return FromFloor(law, count, stop);
  }
  if (library == nullptr) {
    return absl::InvalidArgumentError(
        "--start: expected --motions for a start from a clip, or fallen");
  }
  if (kind.kind == StartKind::Kind::kGiven) {
    return FromGiven(law, *library, kind);
  }
  return FromClips(law, *library, kind.kind, count, seed, stop);
}

}  // namespace sinew::sampling
