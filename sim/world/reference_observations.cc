#include "sim/world/reference_observations.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/check.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/world/body_state.h"
#include "sim/world/observation.h"

namespace sinew::world {
namespace {

// Changes whenever a formula of observation.h does.
constexpr char kFormula[] = "reference observations, version 1";
constexpr char kFile[] = "observations.features.safetensors";

// Writes the rows of a library one after another.
class Observer {
 public:
  Observer(const TrackingTask& task, ObservationBuilder builder)
      : library_(task.library()),
        reader_(task.character()),
        builder_(std::move(builder)),
        body_(reader_.num_bodies(), reader_.num_joints()),
        ahead_(builder_.frames_ahead().size(), body_) {
    for (size_t i = 0; i < ahead_.size(); ++i) {
      frames_.push_back(std::make_unique<motion::ReferenceFrame>(library_));
    }
    contact_.resize(ahead_.size());
  }

  void Write(int clip, int64_t frame, absl::Span<float> out) {
    const motion::FrameView now = library_.frame(clip, frame);
    reader_.Read(now, &body_);
    for (size_t i = 0; i < ahead_.size(); ++i) {
      frames_[i]->Load(clip, frame + builder_.frames_ahead()[i]);
      reader_.Read(frames_[i]->view(), &ahead_[i]);
      contact_[i] = frames_[i]->view().contact;
    }
    builder_.Build({.body = &body_,
                    .reference = ahead_,
                    .reference_contact = contact_,
                    .previous_target = body_.joint_position,
                    .self_contact = absl::MakeConstSpan(
                        now.contact, static_cast<size_t>(library_.num_feet()))},
                   out);
  }

 private:
  const motion::Library& library_;
  const BodyReader reader_;
  const ObservationBuilder builder_;
  BodyState body_;
  std::vector<BodyState> ahead_;
  std::vector<std::unique_ptr<motion::ReferenceFrame>> frames_;
  std::vector<const float*> contact_;
};

absl::StatusOr<TensorMap> Compute(const TrackingTask& task) {
  SINEW_ASSIGN_OR_RETURN(
      ObservationBuilder builder,
      ObservationBuilder::Create(
          task.recipe().task().observation(),
          static_cast<int>(task.character().tracked().size()),
          static_cast<int>(task.character().joints().size()),
          static_cast<int>(task.character().foot_bodies().size())));
  const motion::Library& library = task.library();
  const int width = builder.width();
  Observer observer(task, std::move(builder));
  TensorMap tensors;
  tensors["observation"] =
      HostTensor::Zeros({library.manifest().num_frames(), width});
  absl::Span<float> rows = tensors["observation"].mutable_float32();
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    for (int64_t t = 0; t < library.clip(clip).num_frames(); ++t) {
      observer.Write(clip, t, rows.subspan(0, width));
      rows.remove_prefix(width);
    }
  }
  return tensors;
}

}  // namespace

absl::StatusOr<std::unique_ptr<const ReferenceObservations>>
ReferenceObservations::Open(const TrackingTask& task,
                            const std::string& directory) {
  const motion::Library& library = task.library();
  const motion::FeatureKey key = {
      .library = &library,
      // Column names say blocks, frames ahead, joints, bodies and feet.
      .definition =
          absl::StrCat(kFormula, "; character ", task.character().digest(),
                       "; ", absl::StrJoin(task.ObservationNames(), " ")),
      .shapes = {
          {"observation",
           {library.manifest().num_frames(), task.observation_width()}}}};
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<const motion::FeatureFile> file,
      motion::FeatureFile::OpenOrCompute(JoinPath(directory, kFile), key,
                                         [&] { return Compute(task); }));
  return std::unique_ptr<const ReferenceObservations>(new ReferenceObservations(
      library, task.observation_width(), std::move(file)));
}

absl::Span<const float> ReferenceObservations::Row(int clip,
                                                   int64_t frame) const {
  const v1::ClipInfo& info = library_->clip(clip);
  SINEW_DCHECK(frame >= 0 && frame < info.num_frames()) << "frame " << frame;
  return rows_.subspan((info.first_frame() + frame) * width_, width_);
}

}  // namespace sinew::world
