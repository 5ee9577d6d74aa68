#include "sim/motion/testing/sample_library.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/files.h"
#include "google/protobuf/util/json_util.h"
#include "nlohmann/json.hpp"

namespace sinew::motion::testing {

Sample MakeSample() {
  Sample sample;
  std::map<std::string, std::vector<float>> rows;
  const auto add = [&](const std::string& name, std::vector<double> values) {
    for (const double value : values) {
      rows[name].push_back(static_cast<float>(value));
    }
  };
  const double rate = kTurn * kRate / kFrames;  // rad/s on a unit circle
  for (int i = 0; i < 2 * kFrames; ++i) {
    const double yaw = kTurn * (i % kFrames) / kFrames;
    const double s = std::sin(yaw), c = std::cos(yaw);
    const double h = std::sin(yaw / 2), w = std::cos(yaw / 2);
    for (const std::string part : {"root", "body"}) {
      add(part + "_position", {5 + s, 3 - c, 1});
      add(part + "_rotation", {w, 0, 0, h});
      add(part + "_linear_velocity", {rate * c, rate * s, 0});
      add(part + "_angular_velocity", {0, 0, rate});
    }
    add("joint_position", {0.1 * i});
    add("joint_velocity", {0.2 * i + 1});
    add("contact", {i % 2 == 0 ? 1.0 : 0.0});
    add("feedforward_torque", {3.0 * i});
  }
  for (const auto& [name, values] : rows) {
    const auto width = static_cast<int64_t>(values.size()) / (2 * kFrames);
    std::vector<int64_t> shape = {2 * kFrames, width};
    if (name.substr(0, 5) == "body_") shape = {2 * kFrames, 1, width};
    sample.frames[name] = HostTensor::Float32(shape, values);
  }
  v1::MotionLibrary& m = sample.manifest;
  m.set_character("top");
  m.set_frames_per_second(kRate);
  m.add_joints("spin");
  m.add_bodies("body");
  m.add_feet("body");
  m.set_num_frames(2 * kFrames);
  for (const char* name : {"arc", "once"}) {
    v1::ClipInfo* clip = m.add_clips();
    clip->set_name(name);
    clip->set_first_frame(name[0] == 'a' ? 0 : kFrames);
    clip->set_num_frames(kFrames);
    clip->set_loops(name[0] == 'a');
  }
  m.mutable_clips(0)->set_cycle_x(std::sin(kTurn));
  m.mutable_clips(0)->set_cycle_y(1 - std::cos(kTurn));
  m.mutable_clips(0)->set_cycle_yaw(kTurn);
  return sample;
}

std::string Folder(const std::string& name) {
  return JoinPath(::testing::TempDir(), name);
}

std::unique_ptr<Library> SaveAndLoad(const std::string& name) {
  const Sample sample = MakeSample();
  const absl::Status saved =
      Library::Save(sample.manifest, sample.frames, Folder(name));
  SINEW_CHECK(saved.ok()) << saved;
  auto library = Library::Load(Folder(name));
  SINEW_CHECK(library.ok()) << library.status();
  return *std::move(library);
}

Files GoodFiles() {
  SaveAndLoad("good");
  return {*ReadFile(JoinPath(Folder("good"), "manifest.json")),
          *ReadFile(JoinPath(Folder("good"), "frames.safetensors"))};
}

namespace {

constexpr int kJoints = 28;
constexpr int kBodies = 17;
constexpr int kFeet = 2;

v1::MotionLibrary SparseManifest(int64_t frames, int clips) {
  v1::MotionLibrary manifest;
  manifest.set_format_version(1);
  manifest.set_character("nobody");
  manifest.set_frames_per_second(kRate);
  for (int i = 0; i < kJoints; ++i) manifest.add_joints(absl::StrCat("j", i));
  for (int i = 0; i < kBodies; ++i) manifest.add_bodies(absl::StrCat("b", i));
  for (int i = 0; i < kFeet; ++i) manifest.add_feet(absl::StrCat("b", i));
  manifest.set_frames_sha256(std::string(64, '0'));
  manifest.set_num_frames(frames);
  for (int i = 0; i < clips; ++i) {
    v1::ClipInfo* clip = manifest.add_clips();
    clip->set_name(absl::StrCat("clip_", i));
    clip->set_first_frame(frames * i / clips);
    clip->set_num_frames(frames * (i + 1) / clips - clip->first_frame());
    clip->set_source_file(absl::StrCat("clip_", i, ".bvh"));
    clip->set_source_sha256(std::string(64, '0'));
    // As many figures as an importer leaves.
    v1::ClipQuality* quality = clip->mutable_quality();
    quality->set_joint_fit_max_rad(0.123456789);
    for (int joint = 0; joint < 20; ++joint) {
      v1::RetargetError* error = quality->add_retarget_errors();
      error->set_joint(absl::StrCat("joint_", joint));
      error->set_mean_m(0.0123456789);
      error->set_max_m(0.0234567891);
    }
  }
  return manifest;
}

}  // namespace

void MakeSparseLibrary(double hours, int clips, const std::string& folder) {
  const auto frames = static_cast<int64_t>(hours * 3600 * kRate);
  const std::map<std::string, std::vector<int64_t>> shapes = {
      {"root_position", {frames, 3}},
      {"root_rotation", {frames, 4}},
      {"root_linear_velocity", {frames, 3}},
      {"root_angular_velocity", {frames, 3}},
      {"joint_position", {frames, kJoints}},
      {"joint_velocity", {frames, kJoints}},
      {"body_position", {frames, kBodies, 3}},
      {"body_rotation", {frames, kBodies, 4}},
      {"body_linear_velocity", {frames, kBodies, 3}},
      {"body_angular_velocity", {frames, kBodies, 3}},
      {"contact", {frames, kFeet}},
      {"feedforward_torque", {frames, kJoints}}};
  nlohmann::json header;
  int64_t end = 0;
  for (const auto& [name, shape] : shapes) {
    int64_t size = sizeof(float);
    for (const int64_t extent : shape) size *= extent;
    header[name] = {{"dtype", "F32"},
                    {"shape", shape},
                    {"data_offsets", {end, end + size}}};
    end += size;
  }
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');
  const uint64_t length = text.size();
  text.insert(0, reinterpret_cast<const char*>(&length), sizeof(length));
  const auto size = static_cast<int64_t>(text.size()) + end;
  std::string manifest;
  SINEW_CHECK(google::protobuf::util::MessageToJsonString(
                  SparseManifest(frames, clips), &manifest)
                  .ok());
  const std::string path = JoinPath(folder, "frames.safetensors");
  SINEW_CHECK(MakeDirectories(folder).ok());
  SINEW_CHECK(WriteFileAtomically(path, text).ok());
  std::filesystem::resize_file(path, static_cast<uintmax_t>(size));
  SINEW_CHECK(
      WriteFileAtomically(JoinPath(folder, "manifest.json"), manifest).ok());
}

}  // namespace sinew::motion::testing
