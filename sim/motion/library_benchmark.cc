// What opening a long library costs. Run by hand:
//   bazel run --config=opt //sim/motion:library_benchmark
#include <benchmark/benchmark.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "common/check.h"
#include "sim/motion/features.h"
#include "sim/motion/library.h"
#include "sim/motion/testing/sample_library.h"

namespace sinew::motion {
namespace {

// Ten hours in 4000 clips, its manifest as an importer leaves it.
const std::string& LongLibrary() {
  static const std::string& folder = *new std::string([] {
    std::string made =
        std::filesystem::temp_directory_path() / "sinew_library_benchmark";
    testing::MakeSparseLibrary(/*hours=*/10, /*clips=*/4000, made);
    return made;
  }());
  return folder;
}

void BM_OpenTenHours(benchmark::State& state) {
  for (auto _ : state) {
    auto library = Library::Load(LongLibrary());
    SINEW_CHECK(library.ok()) << library.status();
    benchmark::DoNotOptimize(library);
  }
}
BENCHMARK(BM_OpenTenHours)->Unit(benchmark::kMillisecond);

// All bytes through SHA-256 (which a hole in the disk does not have).
void BM_VerifyTenHours(benchmark::State& state) {
  const auto library = Library::Load(LongLibrary());
  SINEW_CHECK(library.ok()) << library.status();
  for (auto _ : state) {
    benchmark::DoNotOptimize((*library)->Verify());
  }
}
BENCHMARK(BM_VerifyTenHours)->Unit(benchmark::kMillisecond)->Iterations(1);

void BM_ReferenceFrame(benchmark::State& state) {
  const auto library = Library::Load(LongLibrary());
  SINEW_CHECK(library.ok()) << library.status();
  ReferenceFrame frame(**library);
  int64_t i = 0;
  for (auto _ : state) {
    frame.Load(static_cast<int>(i * 7919 % 4000), i % 270);
    ++i;
  }
}
BENCHMARK(BM_ReferenceFrame);

const FeatureDefinition kHandsAndFeet = {
    .end_effectors = {"b0", "b1", "b2", "b3"}};

// Features of an hour of clips, computed and written.
void BM_ComputeFeaturesOfAnHour(benchmark::State& state) {
  const std::string folder =
      std::filesystem::temp_directory_path() / "sinew_feature_benchmark";
  testing::MakeSparseLibrary(/*hours=*/1, /*clips=*/400, folder);
  const auto library = Library::Load(folder);
  SINEW_CHECK(library.ok()) << library.status();
  for (auto _ : state) {
    std::filesystem::remove(folder + "/vmp.features.safetensors");
    auto features = MotionFeatures::Open(**library, kHandsAndFeet, folder);
    SINEW_CHECK(features.ok()) << features.status();
  }
}
BENCHMARK(BM_ComputeFeaturesOfAnHour)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(2);

// A training window: 31 frames at 30 Hz.
void BM_FeatureWindow(benchmark::State& state) {
  const std::string folder =
      std::filesystem::temp_directory_path() / "sinew_feature_benchmark";
  testing::MakeSparseLibrary(/*hours=*/1, /*clips=*/400, folder);
  const auto library = Library::Load(folder);
  SINEW_CHECK(library.ok()) << library.status();
  const auto features = MotionFeatures::Open(**library, kHandsAndFeet, folder);
  SINEW_CHECK(features.ok()) << features.status();
  std::vector<float> window(31 * (*features)->width());
  int64_t i = 0;
  for (auto _ : state) {
    (*features)->Window(static_cast<int>(i * 7919 % 400), i % 270, 15,
                        absl::MakeSpan(window));
    ++i;
  }
}
BENCHMARK(BM_FeatureWindow);

}  // namespace
}  // namespace sinew::motion

BENCHMARK_MAIN();
