// What a save costs: an artifact of 6 MB of new weights and a shared megabyte,
// as the learner saves it (put, alias, retain three), beside reading it back
// and beside the digest and the write alone:
//
//   bazel run --config=opt //deploy/checkpoint:local_store_benchmark
#include <memory>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "benchmark/benchmark.h"
#include "common/check.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "deploy/checkpoint/local_store.h"

namespace sinew::checkpoint {
namespace {

constexpr int64_t kWeights = 6 << 20;
constexpr char kFolder[] = "/tmp/sinew-local-store-benchmark";

std::string RandomBytes(int64_t size) {
  std::minstd_rand random(1);
  std::string bytes(size, 0);
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::unique_ptr<LocalStore> NewStore(const Clock& clock) {
  SINEW_CHECK(RemoveRecursively(kFolder).ok());
  return *LocalStore::Open(kFolder, clock);
}

void Save(ArtifactStore& store, int iteration, std::string& weights,
          const Blob& shared) {
  weights[0] = static_cast<char>(iteration);
  weights[1] = static_cast<char>(iteration >> 8);
  v1::Artifact record;
  record.set_id(absl::StrCat("state-", iteration));
  record.set_kind("state");
  const auto blob = std::make_shared<const std::string>(weights);
  SINEW_CHECK(
      PutFiles(store, record, {{"weights", blob}, {"shared", shared}}).ok());
  SINEW_CHECK(store.SetAlias("latest", record.id()).ok());
  SINEW_CHECK(store.Retain("state", 3).ok());
}

void BM_Save(benchmark::State& state) {
  const SystemClock clock;
  const auto store = NewStore(clock);
  std::string weights = RandomBytes(kWeights);
  const auto shared = std::make_shared<const std::string>(RandomBytes(1 << 20));
  int iteration = 0;
  for (auto _ : state) Save(*store, ++iteration, weights, shared);
}
BENCHMARK(BM_Save)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_Load(benchmark::State& state) {
  const SystemClock clock;
  const auto store = NewStore(clock);
  std::string weights = RandomBytes(kWeights);
  Save(*store, 1, weights, std::make_shared<const std::string>("shared"));
  for (auto _ : state) SINEW_CHECK(GetFiles(*store, "latest").ok());
}
BENCHMARK(BM_Load)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_DigestAlone(benchmark::State& state) {
  const std::string weights = RandomBytes(kWeights);
  for (auto _ : state) benchmark::DoNotOptimize(Sha256Hex(weights));
}
BENCHMARK(BM_DigestAlone)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_WriteAlone(benchmark::State& state) {
  const std::string weights = RandomBytes(kWeights);
  SINEW_CHECK(MakeDirectories(kFolder).ok());
  for (auto _ : state) {
    SINEW_CHECK(WriteFileAtomically(JoinPath(kFolder, "alone"), weights).ok());
  }
}
BENCHMARK(BM_WriteAlone)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace sinew::checkpoint

BENCHMARK_MAIN();
