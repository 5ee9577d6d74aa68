#include "deploy/runtime/testing/runtime_rig.h"

#include "absl/status/status.h"
#include "common/check.h"
#include "common/files.h"
#include "deploy/bundle/testing/toy_bundle.h"

namespace sinew::runtime::testing {

RuntimeRig::RuntimeRig(const std::function<void(v1::Task&)>& edit,
                       world::testing::ToyClips clips) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  for (int block = 1; block <= 5; ++block) {
    observation.add_blocks(static_cast<v1::Observation::Block>(block));
  }
  observation.clear_frames_ahead();
  observation.add_frames_ahead(2);
  observation.add_frames_ahead(7);
  recipe.mutable_task()->mutable_action()->set_velocity_feedforward(true);
  edit(*recipe.mutable_task());
  toy = world::testing::MakeToyWorld(recipe, clips);
  content = bundle::testing::ToyContent(toy);
  const std::string directory = JoinPath(toy.folder, "bundle");
  const absl::Status written = bundle::WriteBundle(content, directory);
  SINEW_CHECK(written.ok()) << written.ToString();
  runtime = Runtime::Open(directory).value();
  target.resize(runtime->num_joints());
}

std::string RuntimeRig::library() const { return toy.library_folder; }

}  // namespace sinew::runtime::testing
