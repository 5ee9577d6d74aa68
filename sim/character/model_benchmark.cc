// What a physics step costs with and without what is only seen. Run by hand:
//   bazel run --config=opt //sim/character:model_benchmark
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include "common/check.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

// Steps a body that lies where it fell, without torques; `bytes` is the size of
// the compiled model.
void Step(const mjModel* model, benchmark::State& state) {
  const DataPtr data(mj_makeData(model));
  for (int i = 0; i < 240; ++i) mj_step(model, data.get());
  for (auto _ : state) mj_step(model, data.get());
  state.SetItemsProcessed(state.iterations());
  state.counters["bytes"] = static_cast<double>(mj_sizeModel(model));
  state.counters["geoms"] = static_cast<double>(model->ngeom);
}

void BM_StepForPhysics(benchmark::State& state, const char* name) {
  const auto character = Character::Load(name, v1::Physics());
  SINEW_CHECK(character.ok()) << character.status();
  Step((*character)->model(), state);
}

void BM_StepForPictures(benchmark::State& state, const char* name) {
  const auto model = Character::CompileForPictures(name);
  SINEW_CHECK(model.ok()) << model.status();
  Step(model->get(), state);
}

BENCHMARK_CAPTURE(BM_StepForPhysics, g1, "g1");
BENCHMARK_CAPTURE(BM_StepForPictures, g1, "g1");
BENCHMARK_CAPTURE(BM_StepForPhysics, humanoid, "humanoid");
BENCHMARK_CAPTURE(BM_StepForPhysics, cmu_humanoid, "cmu_humanoid");

}  // namespace
}  // namespace sinew::character

BENCHMARK_MAIN();
