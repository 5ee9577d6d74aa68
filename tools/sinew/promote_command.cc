#include "tools/sinew/promote_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/clock.h"
#include "common/cpu.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/rpc/credentials.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "deploy/checkpoint/stable_bundle.h"
#include "tools/promotion/promote_bundle.h"
#include "tools/promotion/promotion_rule.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/security_flags.h"

namespace sinew::tools {
namespace {

struct PromoteOptions {
  std::string store;
  rpc::Security security;
  PromotionOptions promotion;
  int threads = 0;  // 0: all cores
  bool rollback = false;
};

// `common_mm`: its error on the clips that both win, if that was compared.
void PrintRow(const std::string& who, const SetSummary& set,
              std::optional<double> common_mm) {
  absl::PrintF(
      "%-24s %4d of %-4d %6d of %-6d %7.1f %% %12s", who, set.succeeded_clips,
      set.clips, set.succeeded_starts, set.starts, 100 * set.success_rate,
      set.frames > 0 ? absl::StrFormat("%.2f mm", set.means.e_g_mpjpe_mm)
                     : "-");
  if (common_mm) absl::PrintF(" %11.2f mm", *common_mm);
  absl::PrintF("\n");
}

void PrintTable(const Promotion& promotion) {
  const CommonErrors& common = promotion.verdict.common;
  const bool compared = common.clips > 0;
  absl::PrintF("%-24s %12s %16s %9s %12s%s\n", "bundle", "clips", "starts",
               "success", "E_g-mpjpe", compared ? " where both win" : "");
  const auto common_mm = [&](double error_mm) {
    return compared ? std::optional(error_mm) : std::nullopt;
  };
  PrintRow(promotion.id, promotion.candidate.overall,
           common_mm(common.candidate_mm));
  if (promotion.incumbent) {
    PrintRow(promotion.incumbent_id, promotion.incumbent->overall,
             common_mm(common.incumbent_mm));
  }
}

void PrintMove(const std::string& to, const std::string& from) {
  absl::PrintF("%s -> %s (was %s)\n", checkpoint::kStable, to,
               from.empty() ? "none" : from);
}

absl::Status RollBack(checkpoint::ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const std::string before,
                         checkpoint::StableBundle(store));
  SINEW_ASSIGN_OR_RETURN(const std::string now,
                         checkpoint::RollBackStable(store));
  PrintMove(now, before);
  return absl::OkStatus();
}

// What is needed to promote, and means nothing to a rollback.
absl::Status CheckFlags(const PromoteOptions& options) {
  for (const auto& [flag, value] :
       {std::pair("--bundle", &options.promotion.bundle),
        std::pair("--motions", &options.promotion.motions)}) {
    if (value->empty() != options.rollback) {
      return absl::InvalidArgumentError(absl::StrCat(
          flag, ": expected ", options.rollback ? "none with" : "it without",
          " --rollback, found ", value->empty() ? "none" : *value));
    }
  }
  return absl::OkStatus();
}

absl::Status RunPromote(const PromoteOptions& options, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckFlags(options));
  const SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(
      const auto store,
      checkpoint::OpenStore(options.store, checkpoint::StoreAccess::kWrite,
                            options.security, clock, stop));
  if (options.rollback) return RollBack(*store);
  PromotionOptions promotion = options.promotion;
  promotion.evaluation.threads =
      options.threads > 0 ? options.threads : AvailableCpus();
  SINEW_ASSIGN_OR_RETURN(const Promotion result,
                         PromoteBundle(promotion, *store, stop));
  PrintTable(result);
  if (!result.verdict.promoted) {
    return absl::FailedPreconditionError(absl::StrCat(
        promotion.bundle, ": not promoted: ", result.verdict.reason));
  }
  absl::PrintF("%s\n", result.verdict.reason);
  PrintMove(result.id, result.incumbent_id);
  return absl::OkStatus();
}

void AddEvaluationFlags(CLI::App& command, PromoteOptions& options) {
  evaluation::EvaluationOptions& evaluation = options.promotion.evaluation;
  command
      .add_option("--starts", evaluation.starts,
                  "evenly spaced phases per clip (default 32)")
      ->check(CLI::Range(1, 10000));
  command
      .add_option("--seconds", evaluation.seconds,
                  "how long looping clips run on (default 10)")
      ->check(FiniteRange(0, 86400));
  command
      .add_option("--threads", options.threads, "threads (default: all cores)")
      ->check(ThreadRange());
}

}  // namespace

void AddPromoteCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<PromoteOptions>();
  auto* command = AddSubcommand<PromoteOptions>(
      app, "promote",
      "a bundle becomes the stable one if it is no worse than the one that is",
      options, action, RunPromote);
  command
      ->add_option("--store", options->store,
                   "a folder, or a service at HOST:PORT or unix:PATH")
      ->required();
  command->add_option("--bundle", options->promotion.bundle,
                      "the candidate's folder");
  command->add_option("--motions", options->promotion.motions,
                      "library that both are evaluated on");
  command->add_option("--id", options->promotion.id,
                      "of the candidate in the store (default: bundle- and its "
                      "manifest's digest)");
  command
      ->add_option("--success-tolerance",
                   options->promotion.rule.success_tolerance,
                   "share of clips that may succeed less (default 0.01)")
      ->check(FiniteRange(0, 1));
  command
      ->add_option("--error-tolerance", options->promotion.rule.error_tolerance,
                   "share by which E_g-mpjpe may grow, over the clips that "
                   "both win (default 0.02)")
      ->check(FiniteRange(0, 1e6));
  CLI::Option* rollback =
      command->add_flag("--rollback", options->rollback,
                        "back to the bundle that was stable before");
  AddEvaluationFlags(*command, *options);
  for (const char* other : {"--id", "--success-tolerance", "--error-tolerance",
                            "--starts", "--seconds", "--threads"}) {
    rollback->excludes(command->get_option(other));
  }
  AddSecurityFlags(*command, options->security);
}

}  // namespace sinew::tools
