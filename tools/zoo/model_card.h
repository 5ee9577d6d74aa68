#ifndef SINEW_TOOLS_ZOO_MODEL_CARD_H_
#define SINEW_TOOLS_ZOO_MODEL_CARD_H_

#include <string>

#include "absl/status/statusor.h"
#include "tools/zoo/card_facts.h"

namespace sinew::zoo {

// A model card in Markdown: what the policy is and of which character; what it
// was trained on, with licences and credits; how, how long and by which build;
// the papers' metrics on clips trained on and left out, the zero action beside
// them; which clips fail; how to make it again, and how to load it. Equal facts
// give equal bytes.
//
// Thread-safety: pure. Blocking: never. Errors: those of FiguresTable.
absl::StatusOr<std::string> ModelCard(const CardFacts& facts);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_MODEL_CARD_H_
