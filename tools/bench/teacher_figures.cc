#include "tools/bench/teacher_figures.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/policy/builder.h"
#include "common/policy/executor.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/service/teacher_server.h"
#include "teacher/teacher_policy.h"
#include "tools/bench/quantile.h"

namespace sinew::bench {
namespace {

// Rows that the bare executor takes at once.
constexpr int64_t kExecutorRows = 128;

absl::StatusOr<teacher::TeacherPolicy> MakePolicy(
    const TeacherOptions& options) {
  const policy::TrackingPolicyOptions network = {
      .observation_width = options.observation_width,
      .action_width = options.action_width,
      .network = options.network};
  teacher::TeacherPolicy result;
  SINEW_ASSIGN_OR_RETURN(result.graph, policy::BuildTrackingPolicy(network));
  SINEW_ASSIGN_OR_RETURN(result.weights, policy::InitialWeights(network, 1));
  result.manifest.set_manifest_sha256("bench");
  result.manifest.set_observation_width(options.observation_width);
  result.manifest.set_action_width(options.action_width);
  for (int64_t j = 0; j < options.action_width; ++j) {
    v1::BundleJoint* joint = result.manifest.add_joints();
    joint->set_name(absl::StrCat("joint_", j));
    joint->set_stiffness(100);
    joint->set_torque_limit(100);
    joint->set_lower(-3);
    joint->set_upper(3);
    result.joint_action_scales.push_back(0);
  }
  return result;
}

// The bare executor over all rows.
double RunExecutor(policy::Executor& executor,
                   const std::vector<float>& observations, int64_t width) {
  const SystemClock clock;
  const double begin = clock.SteadySeconds();
  const absl::Span<float> input =
      executor.input(executor.input_index("observation"));
  const auto rows = static_cast<int64_t>(observations.size()) / width;
  for (int64_t first = 0; first < rows; first += kExecutorRows) {
    const int64_t count = std::min(kExecutorRows, rows - first);
    std::memcpy(input.data(), observations.data() + first * width,
                count * width * sizeof(float));
    executor.Run(static_cast<int>(count));
  }
  return clock.SteadySeconds() - begin;
}

absl::StatusOr<double> RunService(teacher::Annotator& annotator,
                                  absl::Span<const float> observations,
                                  absl::Span<const double> bases) {
  std::vector<double> targets(bases.size());
  const SystemClock clock;
  const double begin = clock.SteadySeconds();
  SINEW_RETURN_IF_ERROR(annotator.Annotate(
      {.observations = observations, .bases = bases}, absl::MakeSpan(targets)));
  return clock.SteadySeconds() - begin;
}

absl::Status MeasureThroughput(const TeacherOptions& options,
                               policy::Executor& executor,
                               teacher::Annotator& annotator,
                               TeacherFigures& figures) {
  std::vector<float> observations(options.rows * options.observation_width);
  FillNormal({.seed = 1}, absl::MakeSpan(observations));
  const std::vector<double> bases(options.rows * options.action_width, 0.1);
  std::vector<double> ratios, served, bare;
  // The first round warms up.
  for (int round = 0; round <= options.rounds; ++round) {
    const double executor_s =
        RunExecutor(executor, observations, options.observation_width);
    SINEW_ASSIGN_OR_RETURN(const double service_s,
                           RunService(annotator, observations, bases));
    if (round == 0) continue;
    bare.push_back(executor_s);
    served.push_back(service_s);
    ratios.push_back(executor_s / service_s);
  }
  const auto rows = static_cast<double>(options.rows);
  figures.throughput_ratio = Median(ratios);
  figures.rows_per_s = rows / Median(served);
  figures.executor_rows_per_s = rows / Median(bare);
  return absl::OkStatus();
}

absl::Status MeasureLatency(const TeacherOptions& options,
                            teacher::Annotator& annotator,
                            TeacherFigures& figures) {
  const std::vector<float> observation(options.observation_width, 0.5F);
  const std::vector<double> base(options.action_width, 0.1);
  std::vector<double> ms;
  for (int call = 0; call < options.calls; ++call) {
    SINEW_ASSIGN_OR_RETURN(const double seconds,
                           RunService(annotator, observation, base));
    ms.push_back(1e3 * seconds);
  }
  figures.latency_p50_ms = Median(ms);
  figures.latency_p99_ms = Quantile(ms, 0.99);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TeacherFigures> MeasureTeacher(const TeacherOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const teacher::TeacherPolicy policy,
                         MakePolicy(options));
  SINEW_ASSIGN_OR_RETURN(
      const auto pack,
      policy::PackWeights(policy.graph, "policy", policy.weights));
  SINEW_ASSIGN_OR_RETURN(const auto executor,
                         policy::Executor::Create(pack, kExecutorRows));
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TemporaryFolder> folder,
                         TemporaryFolder::Create());
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(
      const auto server,
      teacher::TeacherServer::Create(
          {.address = absl::StrCat("unix:", folder->path(), "/teacher"),
           .threads = 1},
          policy, clock));
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<teacher::Annotator> annotator,
      teacher::ConnectAnnotator({.addresses = {server->address()}}));
  TeacherFigures figures;
  SINEW_RETURN_IF_ERROR(
      MeasureThroughput(options, *executor, *annotator, figures));
  SINEW_RETURN_IF_ERROR(MeasureLatency(options, *annotator, figures));
  return figures;
}

}  // namespace sinew::bench
