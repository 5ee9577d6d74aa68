#include "tools/sinew/teacher_command.h"

#include <memory>
#include <string>

#include "absl/time/time.h"
#include "common/cpu.h"
#include "common/status_macros.h"
#include "teacher/service/teacher_server.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/role_logger.h"
#include "tools/sinew/security_flags.h"
#include "tools/teacher/read_teacher.h"

namespace sinew::tools {
namespace {

struct TeacherOptions {
  std::string bundle;
  teacher::TeacherServer::Options server{.threads = AvailableCpus()};
  double delay_ms =
      absl::ToDoubleMilliseconds(teacher::Batcher::Options().batch_delay);
};

absl::Status RunTeacherCommand(const TeacherOptions& options,
                               const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(LogAs("teacher"));
  SINEW_ASSIGN_OR_RETURN(const teacher::TeacherPolicy policy,
                         teacher::ReadTeacher(options.bundle));
  teacher::TeacherServer::Options server = options.server;
  server.batches.batch_delay = absl::Milliseconds(options.delay_ms);
  return teacher::RunTeacher(server, policy, stop);
}

}  // namespace

void AddTeacherCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<TeacherOptions>();
  teacher::TeacherServer::Options& server = options->server;
  CLI::App* command = AddSubcommand<TeacherOptions>(
      app, "teacher", "label states with what a bundle's policy would do",
      options, action, RunTeacherCommand);
  command->add_option("--bundle", options->bundle, "folder of the policy")
      ->required();
  command
      ->add_option("--listen", server.address,
                   "HOST:PORT or unix:PATH; port 0 takes a free one")
      ->required();
  command->add_option("--threads", server.threads, "threads that compute")
      ->check(ThreadRange())
      ->capture_default_str();
  command
      ->add_option("--max-batch", server.batches.max_batch_rows,
                   "rows of a batch, and of a call, at most")
      ->capture_default_str();
  command
      ->add_option("--batch-delay", options->delay_ms,
                   "ms that rows wait for others to share a batch")
      ->check(FiniteRange(0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--queue", server.batches.queue_rows,
                   "rows that may wait; further calls are refused")
      ->capture_default_str();
  command->add_option("--metrics", server.metrics_address,
                      "HOST:PORT for Prometheus; default: none");
  AddSecurityFlags(*command, server.security);
}

}  // namespace sinew::tools
