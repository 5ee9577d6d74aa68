#include "sim/world/testing/toy_world.h"

#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "common/check.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "sim/world/testing/library_maker.h"

namespace sinew::world::testing {
namespace {

constexpr double kRate = 30;

constexpr char kModel[] = R"(
<mujoco model="toy">
  <compiler angle="radian" autolimits="true"/>
  <default><joint type="hinge" axis="0 1 0" range="-1.5 1.5" armature="0.01"/>
    <geom type="capsule" size="0.04"/></default>
  <worldbody>
    <body name="trunk" pos="0 0 0.44">
      <freejoint name="root"/>
      <geom name="trunk" type="box" size="0.3 0.2 0.05" mass="6"/>
      <body name="leg_fl" pos="0.25 0.2 0"><joint name="hip_fl"/>
        <geom name="leg_fl" fromto="0 0 0 0 0 -0.4" mass="1"/></body>
      <body name="leg_fr" pos="0.25 -0.2 0"><joint name="hip_fr"/>
        <geom name="leg_fr" fromto="0 0 0 0 0 -0.4" mass="1"/></body>
      <body name="leg_bl" pos="-0.25 0.2 0"><joint name="hip_bl"/>
        <geom name="leg_bl" fromto="0 0 0 0 0 -0.4" mass="1"/></body>
      <body name="leg_br" pos="-0.25 -0.2 0"><joint name="hip_br"/>
        <geom name="leg_br" fromto="0 0 0 0 0 -0.4" mass="1"/></body>
    </body>
  </worldbody>
</mujoco>)";

constexpr char kCharacter[] = R"(
format_version: 1
name: "toy"
model_file: "toy.xml"
joints { name: "hip_fl" stiffness: 200 damping: 10 torque_limit: 60 }
joints { name: "hip_br" stiffness: 200 damping: 10 torque_limit: 60 }
joints { name: "hip_fr" stiffness: 100 damping: 8 torque_limit: 50
         default_position: 0.1 action_scale: 0.3 }
joints { name: "hip_bl" stiffness: 200 damping: 10 torque_limit: 60 }
feet { body: "leg_fl" geoms: "leg_fl" }
feet { body: "leg_fr" }
head_body: "trunk"
standing_root_height: 0.44
actuator_law { derivation: "stiff enough to stand; for tests" }
provenance: "made for tests"
licence: "Apache-2.0"
)";

// Position and derivative of one coordinate at time t (seconds).
struct Wave {
  double offset = 0, speed = 0, amplitude = 0, frequency = 0, phase = 0;

  double At(double t) const {
    const double w = 2 * std::numbers::pi * frequency;
    return offset + speed * t + amplitude * std::sin(w * t + phase);
  }
  double Rate(double t) const {
    const double w = 2 * std::numbers::pi * frequency;
    return speed + amplitude * w * std::cos(w * t + phase);
  }
};

struct Motion {
  const char* name;
  int frames;
  bool loops;
  Wave x, height, yaw, roll;
  double leg_amplitude;
  double cycle_x = 0, cycle_y = 0, cycle_yaw = 0;
};

// The loop's root goes once along an arc: turning by a over length s moves it
// by s (sin a / a, (1 - cos a) / a).
constexpr double kArcLength = 0.4, kArcTurn = 0.5;

std::vector<Motion> Motions(ToyClips clips) {
  const Wave standing = {.offset = 0.435};
  const Wave rising = {.offset = 0.3, .speed = 0.23};
  const double period = 24 / kRate;
  const double radius = kArcLength / kArcTurn;
  return {{.name = "turn",
           .frames = 24,
           .loops = true,
           .x = {.speed = kArcLength / period},
           .height = {.offset = 0.44, .amplitude = 0.01, .frequency = 2.5},
           .yaw = {.speed = kArcTurn / period},
           .roll = {.amplitude = 0.05, .frequency = 1.25, .phase = 0.3},
           .leg_amplitude = 0.3,
           .cycle_x = radius * std::sin(kArcTurn),
           .cycle_y = radius * (1 - std::cos(kArcTurn)),
           .cycle_yaw = kArcTurn},
          {.name = "sway",
           .frames = 20,
           .loops = false,
           .x = {.offset = 1},
           .height = clips == ToyClips::kWithGetUp ? rising : standing,
           .yaw = {.offset = 2},
           .roll = {},
           .leg_amplitude = 0.05},
          {.name = "tumble",
           .frames = 16,
           .loops = false,
           .x = {.speed = 1.5},
           .height = {.offset = 1.5, .amplitude = 0.3, .frequency = 1},
           .yaw = {.offset = -1, .speed = 2},
           .roll = {.speed = 9},
           .leg_amplitude = 0.4}};
}

// Sets the root: an arc in the plane for the loop, else a line along x; then
// yaw, then roll about the body's x.
void SetRoot(const Motion& motion, double t, mjData* data) {
  const double s = motion.x.At(t);
  const double v = motion.x.Rate(t);
  const double yaw = motion.yaw.At(t);
  const double radius = motion.loops ? kArcLength / kArcTurn : 0;
  data->qpos[0] = motion.loops ? radius * std::sin(yaw) : s;
  data->qpos[1] = motion.loops ? radius * (1 - std::cos(yaw)) : 0;
  data->qpos[2] = motion.height.At(t);
  data->qvel[0] = motion.loops ? v * std::cos(yaw) : v;
  data->qvel[1] = motion.loops ? v * std::sin(yaw) : 0;
  data->qvel[2] = motion.height.Rate(t);
  const double z[3] = {0, 0, 1}, x[3] = {1, 0, 0};
  const double roll = motion.roll.At(t);
  double turn[4], tilt[4];
  mju_axisAngle2Quat(turn, z, yaw);
  mju_axisAngle2Quat(tilt, x, roll);
  mju_mulQuat(data->qpos + 3, turn, tilt);
  // Body-local rate: roll about x, yaw about world z seen from the rolled body.
  data->qvel[3] = motion.roll.Rate(t);
  data->qvel[4] = motion.yaw.Rate(t) * std::sin(roll);
  data->qvel[5] = motion.yaw.Rate(t) * std::cos(roll);
}

void SetPose(const Motion& motion, const character::Character& character,
             double t, mjData* data) {
  SetRoot(motion, t, data);
  for (size_t j = 0; j < character.joints().size(); ++j) {
    const Wave wave{.amplitude = motion.leg_amplitude,
                    .frequency = 1.25,
                    .phase = 1.1 * static_cast<double>(j)};
    data->qpos[character.joints()[j].qpos_address] = wave.At(t);
    data->qvel[character.joints()[j].dof_address] = wave.Rate(t);
  }
  mj_forward(character.model(), data);
}

std::unique_ptr<const motion::Library> MakeLibrary(
    const character::Character& character, ToyClips clips,
    const std::string& folder) {
  LibraryMaker maker(character);
  const character::DataPtr data(mj_makeData(character.model()));
  for (const Motion& motion : Motions(clips)) {
    v1::ClipInfo clip;
    clip.set_name(motion.name);
    clip.set_loops(motion.loops);
    clip.set_cycle_x(motion.cycle_x);
    clip.set_cycle_y(motion.cycle_y);
    clip.set_cycle_yaw(motion.cycle_yaw);
    maker.BeginClip(clip);
    for (int i = 0; i < motion.frames; ++i) {
      SetPose(motion, character, i / kRate, data.get());
      maker.AddFrame(data.get(), motion.height.offset < 1);
    }
  }
  return maker.Make(folder);
}

}  // namespace

v1::Recipe ToyRecipe() { return WithDefaults(v1::Recipe()); }

ToyWorld MakeToyWorld(const v1::Recipe& recipe, ToyClips clips) {
  const std::string folder = NewFolder();
  const std::string text = JoinPath(folder, "character.textproto");
  SINEW_CHECK(WriteFileAtomically(JoinPath(folder, "toy.xml"), kModel).ok());
  SINEW_CHECK(WriteFileAtomically(text, kCharacter).ok());
  ToyWorld world;
  world.folder = folder;
  world.recipe = recipe;
  auto character = character::Character::Load(text, recipe.physics());
  SINEW_CHECK(character.ok()) << character.status().ToString();
  world.character = *std::move(character);
  world.library_folder = JoinPath(folder, "library");
  world.library = MakeLibrary(*world.character, clips, world.library_folder);
  return world;
}

void LeaveOut(std::initializer_list<int> clips, ToyWorld& world) {
  v1::MotionLibrary manifest = world.library->manifest();
  for (const int clip : clips) manifest.mutable_clips(clip)->set_left_out(true);
  std::string json;
  SINEW_CHECK(
      google::protobuf::util::MessageToJsonString(manifest, &json).ok());
  const auto frames =
      ReadFile(JoinPath(world.library_folder, "frames.safetensors"));
  SINEW_CHECK(frames.ok()) << frames.status().ToString();
  auto library = motion::Library::FromBytes(json, *frames, "toy");
  SINEW_CHECK(library.ok()) << library.status().ToString();
  world.library = *std::move(library);
}

void LeaveOutOnDisk(int clip, const std::string& library_folder) {
  const std::string file = JoinPath(library_folder, "manifest.json");
  const auto text = ReadFile(file);
  SINEW_CHECK(text.ok()) << text.status().ToString();
  auto manifest = nlohmann::json::parse(*text);
  auto& clips = manifest.at("clips");
  SINEW_CHECK(clip >= 0 && clip < static_cast<int>(clips.size()))
      << "clip " << clip << " of " << clips.size();
  clips[clip]["left_out"] = true;
  SINEW_CHECK(WriteFileAtomically(file, manifest.dump()).ok());
}

}  // namespace sinew::world::testing
