#include "sim/world/testing/library_maker.h"

#include <cstdint>
#include <cstdlib>

#include "common/check.h"
#include "common/files.h"

namespace sinew::world::testing {
namespace {

constexpr double kRate = 30;  // frames per second

}  // namespace

LibraryMaker::LibraryMaker(const character::Character& character)
    : character_(character) {
  const mjModel* model = character.model();
  manifest_.set_character(character.name());
  manifest_.set_character_sha256(character.digest());
  manifest_.set_frames_per_second(kRate);
  for (const auto& joint : character.joints()) {
    manifest_.add_joints(joint.name);
  }
  for (int body = 1; body < model->nbody; ++body) {
    manifest_.add_bodies(mj_id2name(model, mjOBJ_BODY, body));
  }
  for (int body : character.foot_bodies()) {
    manifest_.add_feet(mj_id2name(model, mjOBJ_BODY, body));
  }
}

void LibraryMaker::BeginClip(const v1::ClipInfo& info) {
  v1::ClipInfo* clip = manifest_.add_clips();
  *clip = info;
  clip->set_first_frame(manifest_.num_frames());
  clip->set_num_frames(0);
  clip->set_provenance("made for tests");
  clip->set_licence("Apache-2.0");
}

void LibraryMaker::Add(const std::string& name, const mjtNum* values,
                       int count) {
  for (int i = 0; i < count; ++i) {
    values_[name].push_back(static_cast<float>(values[i]));
  }
}

void LibraryMaker::AddFrame(const mjData* data, bool contact) {
  const mjModel* model = character_.model();
  double angular[3];
  mju_rotVecQuat(angular, data->qvel + 3, data->qpos + 3);
  Add("root_position", data->qpos, 3);
  Add("root_rotation", data->qpos + 3, 4);
  Add("root_linear_velocity", data->qvel, 3);
  Add("root_angular_velocity", angular, 3);
  const double label = contact ? 1 : 0;
  for (const auto& joint : character_.joints()) {
    const double torque = 10 * data->qpos[joint.qpos_address];
    Add("joint_position", data->qpos + joint.qpos_address, 1);
    Add("joint_velocity", data->qvel + joint.dof_address, 1);
    Add("feedforward_torque", &torque, 1);
  }
  for (size_t f = 0; f < character_.foot_bodies().size(); ++f) {
    Add("contact", &label, 1);
  }
  for (int body = 1; body < model->nbody; ++body) {
    double velocity[6];  // rotational, then linear
    mj_objectVelocity(model, data, mjOBJ_XBODY, body, velocity, 0);
    Add("body_position", data->xpos + 3 * body, 3);
    Add("body_rotation", data->xquat + 4 * body, 4);
    Add("body_angular_velocity", velocity, 3);
    Add("body_linear_velocity", velocity + 3, 3);
  }
  auto* clip = manifest_.mutable_clips(manifest_.clips_size() - 1);
  clip->set_num_frames(clip->num_frames() + 1);
  manifest_.set_num_frames(manifest_.num_frames() + 1);
}

TensorMap LibraryMaker::Frames() const {
  const int64_t rows = manifest_.num_frames();
  const int64_t bodies = manifest_.bodies_size();
  TensorMap map;
  for (const auto& [name, values] : values_) {
    const auto width = static_cast<int64_t>(values.size()) / rows;
    std::vector<int64_t> shape = {rows, width};
    if (name.substr(0, 5) == "body_") shape = {rows, bodies, width / bodies};
    map[name] = HostTensor::Float32(shape, values);
  }
  return map;
}

std::unique_ptr<const motion::Library> LibraryMaker::Make(
    const std::string& folder) const {
  const absl::Status saved = motion::Library::Save(manifest_, Frames(), folder);
  SINEW_CHECK(saved.ok()) << saved.ToString();
  auto library = motion::Library::Load(folder);
  SINEW_CHECK(library.ok()) << library.status().ToString();
  return *std::move(library);
}

std::string NewFolder() {
  const char* base = getenv("TEST_TMPDIR");
  std::string path = JoinPath(base == nullptr ? "/tmp" : base, "world.XXXXXX");
  SINEW_CHECK(mkdtemp(path.data()) != nullptr) << path;
  return path;
}

}  // namespace sinew::world::testing
