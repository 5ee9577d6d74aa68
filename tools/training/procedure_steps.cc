#include "tools/training/procedure_steps.h"

#include "common/status_macros.h"

namespace sinew::tools {
namespace {

decltype(ProcedureSteps::evaluate) EvaluateStep(const StopToken& stop) {
  return [stop](const std::string& bundle, const std::string& motions,
                const std::string& out,
                const evaluation::EvaluationOptions& options) {
    return evaluation::EvaluateBundle(bundle, motions, out, options, stop);
  };
}

}  // namespace

ProcedureSteps StepsWithActors(const LocalActors& actors, Clock& clock,
                               const StopToken& stop) {
  return {.train =
              [actors, &clock, stop](const TrainingRun::Options& options) {
                return RunWithActors(options, actors, clock, stop);
              },
          .evaluate = EvaluateStep(stop)};
}

ServedStages::ServedStages(Clock& clock, const StopToken& stop)
    : clock_(clock), stop_(stop) {}

ServedStages::~ServedStages() = default;

ProcedureSteps ServedStages::Steps() {
  return {.train = [this](const auto& options) { return Train(options); },
          .evaluate = EvaluateStep(stop_)};
}

absl::StatusOr<TrainingRun::Result> ServedStages::Train(
    const TrainingRun::Options& options) {
  if (last_ != nullptr) last_->Interrupt();
  last_.reset();
  TrainingRun::Options here = options;
  if (!address_.empty()) here.listen = address_;
  SINEW_ASSIGN_OR_RETURN(last_, TrainingRun::Open(here, clock_, stop_));
  address_ = last_->address();
  SINEW_RETURN_IF_ERROR(last_->Train());
  return last_->result();
}

void ServedStages::Leave(bool done, absl::Duration timeout) {
  if (last_ == nullptr) return;
  if (done) {
    last_->Drain(timeout);
  } else {
    last_->Interrupt();
  }
}

}  // namespace sinew::tools
