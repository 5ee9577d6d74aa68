#ifndef SINEW_ACTOR_TESTING_ROLLOUT_RIG_H_
#define SINEW_ACTOR_TESTING_ROLLOUT_RIG_H_

#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/segment/segment_layout.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor::testing {

// Where an evaluation begins, and for how many steps.
struct Start {
  int clip, frame, steps;
};

// A worker of 4 environments in the toy world, with a small random policy of
// standard deviation `std`, and fallen states if the recipe asks for them.
// Members abort with a message on any error.
struct RolloutRig {
  explicit RolloutRig(
      const v1::Recipe& recipe = world::testing::ToyRecipe(),
      world::testing::ToyClips clips = world::testing::ToyClips::kStanding);

  // Fresh environments 0, 1, ... of run seed 11; order 7.
  v1::Order TrainOrder(int environments, int horizon) const;
  // An environment at the start of the clip in which the toy just stands: its
  // episode lasts 19 steps.
  v1::EnvironmentState StandingState() const;
  // A TrainOrder whose environments are all in that state.
  v1::Order StandingOrder(int environments, int horizon) const;
  v1::Order EvaluationOrder(const std::vector<Start>& starts) const;

  void UseZeroAction();
  // A small policy with a latent of 3 numbers, beside its four other graphs;
  // where PPO learns it, with exploration. The policy of before stays as graph
  // "teacher" if asked for.
  void UseLatentPolicy(bool keep_as_teacher = false);
  // Sets all elements of a parameter of the snapshot.
  void SetParameter(const std::string& name, float value);
  void NewWorker();
  v1::Segment Run(const v1::Order& order);
  // Expects the same bytes of an order whenever it is run: at first, after
  // `other` and in a new worker.
  void ExpectSameBytes(const v1::Order& order, const v1::Order& other);
  // Runs a TrainOrder, and in two halves, the second in a new worker; expects
  // ExpectTogether of them and gives the whole.
  v1::Segment RunWholeAndInHalves(int environments, int horizon);
  // Expects that two segments, one after the other, are `whole`: its steps, its
  // episodes, its end.
  void ExpectTogether(const v1::Segment& whole, const v1::Segment& first,
                      const v1::Segment& second) const;

  // Expects that every row's log probability is that of a Gaussian of deviation
  // `std` around its mean, computed as a product of densities.
  void ExpectGaussianLogProbabilities(const v1::Segment& segment) const;

  const double std = 0.25;
  std::shared_ptr<const RolloutAssets> assets;
  // The same by role, as actors fetch them.
  std::map<std::string, std::string> asset_bytes;
  v1::Snapshot message;
  std::shared_ptr<const PreparedSnapshot> snapshot;
  std::unique_ptr<RolloutWorker> worker;

 private:
  void Prepare();
};

// All of a segment but the seconds it took.
std::string Bytes(v1::Segment segment);

// A column's numbers.
template <typename T>
std::vector<T> Column(const v1::Segment& segment, absl::string_view name) {
  const std::string& data = FindColumn(segment, name)->data();
  std::vector<T> values(data.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), data.data(), data.size());
  return values;
}

}  // namespace sinew::actor::testing

#endif  // SINEW_ACTOR_TESTING_ROLLOUT_RIG_H_
