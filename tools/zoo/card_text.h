#ifndef SINEW_TOOLS_ZOO_CARD_TEXT_H_
#define SINEW_TOOLS_ZOO_CARD_TEXT_H_

#include <string>

#include "tools/zoo/card_facts.h"

namespace sinew::zoo {

// Chapters of a model card that are about its limits and its use (trained_on.h
// and model_card.h have the others). Markdown that ends with a newline; text of
// other people's files stays text.
//
// Thread-safety: pure. Blocking: never. Errors: none.

// Clips that fail in the evaluation, with the force that their motion leaves
// unexplained (sim/import/quality.h).
std::string LimitationsChapter(const CardFacts& facts);

// The commands, and how to load the bundle from C and from Python.
std::string ReproduceChapter(const CardFacts& facts);
std::string LoadChapter(const CardFacts& facts);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_CARD_TEXT_H_
