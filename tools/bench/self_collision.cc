// What self-collision costs: mj_step/s with it over mj_step/s without, of the
// same states on one thread, the two taking turns in one run.
//
//   bazel run -c opt //tools/bench:self_collision -- [--character g1]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "sim/character/character.h"

namespace sinew {
namespace {

struct Body {
  std::unique_ptr<const character::Character> character;
  character::DataPtr data;
};

absl::StatusOr<Body> Load(const std::string& name, bool self_collision) {
  v1::Physics physics;
  physics.set_self_collision(self_collision);
  Body body;
  SINEW_ASSIGN_OR_RETURN(body.character,
                         character::Character::Load(name, physics));
  body.data.reset(mj_makeData(body.character->model()));
  return body;
}

// Default pose at standing height, or on its back just above the floor.
void Place(const Body& body, bool lying) {
  const mjModel* model = body.character->model();
  mj_resetData(model, body.data.get());
  for (const character::JointInfo& joint : body.character->joints()) {
    body.data->qpos[joint.qpos_address] = joint.default_position;
  }
  double* root = body.data->qpos;
  root[2] = lying ? 0.2 : body.character->proto().standing_root_height();
  if (!lying) return;
  root[3] = root[5] = std::sqrt(0.5);
  root[5] *= -1;
}

// Seconds of one fall: joints pulled to the default pose.
double Fall(const Body& body, bool lying, int steps) {
  Place(body, lying);
  const double begin = ThreadSeconds();
  for (int i = 0; i < steps; ++i) {
    for (const character::JointInfo& joint : body.character->joints()) {
      body.data->qfrc_applied[joint.dof_address] =
          std::clamp(joint.stiffness * (joint.default_position -
                                        body.data->qpos[joint.qpos_address]),
                     -joint.torque_limit, joint.torque_limit);
    }
    mj_step(body.character->model(), body.data.get());
  }
  return ThreadSeconds() - begin;
}

absl::Status Run(const std::string& name, int repeats) {
  constexpr int kSteps = 120;
  SINEW_ASSIGN_OR_RETURN(const Body with, Load(name, true));
  SINEW_ASSIGN_OR_RETURN(const Body without, Load(name, false));
  for (const bool lying : {false, true}) {
    std::vector<double> ratios;
    for (int i = 0; i < repeats; ++i) {
      const double off = Fall(without, lying, kSteps);
      ratios.push_back(off / Fall(with, lying, kSteps));
    }
    std::sort(ratios.begin(), ratios.end());
    std::printf("%-10s %-8s speed with over without: %.3f (%.3f to %.3f)\n",
                name.c_str(), lying ? "lying" : "standing",
                ratios[ratios.size() / 2], ratios[ratios.size() / 4],
                ratios[ratios.size() * 3 / 4]);
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  std::string character = "humanoid";
  int repeats = 25;
  CLI::App app("Cost of self-collision");
  app.add_option("--character", character, "name or file");
  app.add_option("--repeats", repeats, "pairs of runs");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = sinew::Run(character, repeats);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
