// What the physics of an import costs: refinement and analysis of ten seconds
// of a made motion, per frame.
//
//   bazel run --config=opt //tools/bench:refine_benchmark
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/check.h"
#include "sim/character/character.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/quality.h"
#include "sim/import/retarget/refine.h"

namespace sinew {
namespace {

constexpr double kRate = 30;
constexpr int kFrames = 300;

// A character that swings all its joints, each to its own beat, and stands with
// its lowest point on the floor.
struct Clip {
  explicit Clip(const std::string& name) {
    auto loaded = character::Character::Load(name, v1::Physics());
    SINEW_CHECK(loaded.ok()) << loaded.status().message();
    character = *std::move(loaded);
    model = import::MakeImportModel(*character);
    dynamics = std::make_unique<import::Dynamics>(model);
    motion.rate = kRate;
    for (int t = 0; t < kFrames; ++t) motion.qpos.push_back(Pose(t));
    supported = import::FindSupport(dynamics.get(), motion, 0);
    bearing = import::FindBearingPoints(dynamics.get(), supported, motion);
  }

  Eigen::VectorXd Pose(int t) {
    Eigen::VectorXd qpos =
        Eigen::Map<const Eigen::VectorXd>(model.model->qpos0, model.model->nq);
    for (size_t j = 0; j < model.joints.size(); ++j) {
      const double hz = 0.5 + 0.03 * static_cast<double>(j);
      qpos[model.joints[j].qpos_address] +=
          0.15 * std::sin(2 * std::numbers::pi * hz * t / kRate);
    }
    dynamics->SetPose(qpos);
    qpos[2] -= dynamics->LowestHeight();
    return qpos;
  }

  std::unique_ptr<const character::Character> character;
  import::ImportModel model;
  std::unique_ptr<import::Dynamics> dynamics;
  import::ModelMotion motion;
  std::vector<bool> supported;
  std::vector<std::vector<bool>> bearing;
};

void PerFrame(benchmark::State& state) {
  // Shown as seconds per frame, "2.1m" for 2.1 ms.
  state.counters["s/frame"] = benchmark::Counter(
      kFrames, benchmark::Counter::kIsIterationInvariantRate |
                   benchmark::Counter::kInvert);
}

void BM_Refine(benchmark::State& state, const std::string& name) {
  Clip clip(name);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        import::RefineMotion(clip.dynamics.get(), clip.bearing, clip.motion));
  }
  PerFrame(state);
}

void BM_Analyse(benchmark::State& state, const std::string& name) {
  Clip clip(name);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        import::AnalyseMotion(clip.dynamics.get(), clip.motion));
  }
  PerFrame(state);
}

BENCHMARK_CAPTURE(BM_Refine, humanoid, "humanoid")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Refine, g1, "g1")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Analyse, humanoid, "humanoid")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Analyse, g1, "g1")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sinew

BENCHMARK_MAIN();
