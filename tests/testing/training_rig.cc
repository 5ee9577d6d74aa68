#include "tests/testing/training_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/rpc/retry.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/local_store.h"
#include "learner/state/state_store.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;

constexpr absl::Duration kLongest = absl::Minutes(2);
constexpr absl::Duration kPoll = absl::Milliseconds(5);

constexpr char kProgram[] = "tools/sinew/sinew";

constexpr char kRecipe[] = R"(
format_version: 1
name: "tiny"
network { policy_hidden: 16 value_hidden: 16 }
rollouts { environments: 8 environments_per_order: 2 horizon: 8 }
ppo { epochs: 2 minibatch: 32 shards: 2 }
evaluation { interval: 2 starts: 2 seconds: 0.5 }
checkpointing { interval: 1 keep: 2 }
seed: 3
)";

}  // namespace

TrainingRig::TrainingRig() : toy_(world::testing::MakeToyWorld()) {
  EXPECT_THAT(WriteFileAtomically(ToyFile("tiny.textproto"), kRecipe), IsOk());
}

std::string TrainingRig::Path(const std::string& name) const {
  return JoinPath(toy_.folder, name);
}

std::string TrainingRig::ToyFile(const std::string& name) const {
  return JoinPath(toy_.folder, name);
}

TrainingRig::Arguments TrainingRig::Train(const std::string& run,
                                          int iterations,
                                          const Arguments& more) const {
  Arguments arguments = {"train",
                         "--recipe",
                         ToyFile("tiny.textproto"),
                         "--motions",
                         toy_.library_folder,
                         "--character",
                         ToyFile("character.textproto"),
                         "--run",
                         Path(run)};
  if (iterations > 0) {
    arguments.insert(arguments.end(),
                     {"--iterations", absl::StrCat(iterations)});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TrainingRig::Arguments TrainingRig::Learner(const std::string& run,
                                            int iterations,
                                            const Arguments& more) const {
  Arguments arguments = Train(run, iterations, more);
  arguments[0] = "learner";
  return arguments;
}

std::unique_ptr<Subprocess> TrainingRig::Start(
    const std::string& name, const Arguments& arguments) const {
  Subprocess::Options options;
  options.argv = {kProgram};
  options.argv.insert(options.argv.end(), arguments.begin(), arguments.end());
  options.output_file = Path(name + ".out");
  auto process = Subprocess::Start(options);
  EXPECT_THAT(process, IsOk());
  return *std::move(process);
}

ExitStatus TrainingRig::Run(const std::string& name,
                            const Arguments& arguments) const {
  const auto process = Start(name, arguments);
  const auto status = process->Wait(kLongest);
  EXPECT_TRUE(status.ok()) << status.status() << "\n" << Output(name);
  return status.ok() ? *status : process->Terminate(absl::Seconds(1));
}

void TrainingRig::MustRun(const std::string& name,
                          const Arguments& arguments) const {
  const ExitStatus status = Run(name, arguments);
  ASSERT_TRUE(status.ok()) << status.ToString() << "\n" << Output(name);
}

std::string TrainingRig::Output(const std::string& name) const {
  return ReadFile(Path(name + ".out")).value_or("");
}

std::string TrainingRig::AwaitAddress(Subprocess& process,
                                      const std::string& name) const {
  std::string address;
  Await(process, [&] {
    address = AddressIn(Output(name), "address=");
    return !address.empty();
  });
  return address;
}

learner::Trainer::State TrainingRig::StateOf(const std::string& run) const {
  return LatestState(JoinPath(Path(run), "checkpoints"));
}

std::string TrainingRig::FingerprintOf(const std::string& run) const {
  return Fingerprint(StateOf(run));
}

std::string TrainingRig::TensorsOf(const std::string& run) const {
  return Sha256Hex(SerializeSafetensors(StateOf(run).tensors));
}

int TrainingRig::Rows(const std::string& run) const {
  const auto text = ReadFile(JoinPath(Path(run), "metrics.jsonl"));
  return text.ok()
             ? static_cast<int>(std::count(text->begin(), text->end(), '\n'))
             : 0;
}

void TrainingRig::AwaitRows(Subprocess& process, const std::string& run,
                            int rows) const {
  Await(process, [&] { return Rows(run) >= rows; });
}

void TrainingRig::KillAfter(const std::string& run, int rows,
                            absl::Duration moment,
                            const Arguments& arguments) const {
  const auto process = Start("killed", arguments);
  AwaitRows(*process, run, rows);
  (void)process->Wait(moment);
  process->Signal(SIGKILL);
  const auto end = process->Wait(absl::Minutes(1));
  ASSERT_THAT(end, IsOk());
  ASSERT_EQ(end->signal, SIGKILL) << Output("killed");
}

std::string AddressIn(const std::string& log, const std::string& message) {
  const size_t line = log.find(message);
  if (line == std::string::npos) return "";
  const std::string mark = "address=";
  const size_t at = log.find(mark, line);
  if (at == std::string::npos) return "";
  const size_t begin = at + mark.size();
  if (log.find('\n', begin) == std::string::npos) return "";
  return log.substr(begin, log.find_first_of(" \n", begin) - begin);
}

void AwaitTrue(const std::function<bool()>& holds) {
  const auto deadline =
      std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(kLongest);
  while (!holds()) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    rpc::WaitFor(kPoll, {});
  }
}

void Await(Subprocess& process, const std::function<bool()>& holds) {
  AwaitTrue([&] { return holds() || process.exit_status().has_value(); });
  ASSERT_TRUE(holds()) << "the process has ended";
}

learner::Trainer::State LatestState(const std::string& folder) {
  const SystemClock clock;
  const auto store = checkpoint::LocalStore::OpenReadOnly(folder, clock);
  EXPECT_THAT(store, IsOk());
  if (!store.ok()) return {};
  std::vector<std::string> warnings;
  auto state = learner::LoadLatestState(**store, &warnings);
  EXPECT_THAT(state, IsOk());
  EXPECT_THAT(warnings, ::testing::IsEmpty());
  return state.ok() ? *std::move(state) : learner::Trainer::State();
}

std::string Fingerprint(const learner::Trainer::State& state) {
  v1::TrainingState counters = state.counters;
  counters.clear_train_seconds();
  counters.clear_wall_seconds();
  std::string all = SerializeDeterministically(counters);
  absl::StrAppend(&all, SerializeSafetensors(state.tensors));
  for (const std::string& snapshot : state.snapshots) {
    absl::StrAppend(&all, snapshot);
  }
  return Sha256Hex(all);
}

std::vector<pid_t> ChildrenOf(pid_t pid) {
  std::vector<pid_t> children;
  for (const std::string& name :
       ListDirectory("/proc").value_or(std::vector<std::string>())) {
    pid_t child = 0;
    if (!absl::SimpleAtoi(name, &child)) continue;
    const auto status = ReadFile(absl::StrCat("/proc/", name, "/status"));
    if (status.ok() &&
        absl::StrContains(*status, absl::StrCat("\nPPid:\t", pid, "\n"))) {
      children.push_back(child);
    }
  }
  return children;
}

bool IsRunning(pid_t pid) {
  const auto status = ReadFile(absl::StrCat("/proc/", pid, "/status"));
  return status.ok() && !absl::StrContains(*status, "State:\tZ");
}

}  // namespace sinew::tests
