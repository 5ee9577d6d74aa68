#include "tools/sinew/card_command.h"

#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "tools/zoo/card_facts.h"
#include "tools/zoo/model_card.h"

namespace sinew::tools {
namespace {

struct CardCommandOptions {
  zoo::CardOptions card;
  std::string out;
};

absl::Status RunCard(const CardCommandOptions& options,
                     const StopToken& /*stop*/) {
  const SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(const zoo::CardFacts facts,
                         zoo::ReadCardFacts(options.card, clock));
  SINEW_ASSIGN_OR_RETURN(const std::string card, zoo::ModelCard(facts));
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(options.out, card));
  absl::PrintF("%s\n", options.out);
  return absl::OkStatus();
}

}  // namespace

void AddCardCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<CardCommandOptions>();
  auto* command = AddSubcommand<CardCommandOptions>(
      app, "card", "a bundle's model card", options, action, RunCard);
  zoo::CardOptions& card = options->card;
  command->add_option("--bundle", card.bundle, "folder")->required();
  command->add_option("--motions", card.motions, "library")->required();
  command->add_option("--out", options->out, "Markdown file")->required();
  command->add_option("--eval", card.eval, "what `sinew eval` wrote of it");
  command->add_option("--fallen", card.fallen,
                      "another such file, with --fallen starts");
  command->add_option("--samples", card.samples,
                      "what `sinew sample` wrote of its prior");
  command->add_option("--run", card.run, "run directory that it comes from");
  command->add_option("--command", card.command,
                      "that trained it (default: what the recipe amounts to)");
  command->add_option("--machine", card.machine,
                      "in words (default: what the run says)");
}

}  // namespace sinew::tools
