#ifndef SINEW_TOOLS_ZOO_CARD_TEXT_H_
#define SINEW_TOOLS_ZOO_CARD_TEXT_H_

#include <string>

#include "tools/zoo/card_facts.h"

namespace sinew::zoo {

// Chapters of a model card that are about its data and its use (model_card.h
// has the others). Markdown that ends with a newline; text of other people's
// files stays text.
//
// Thread-safety: pure. Blocking: never. Errors: none.

// Clips by credit and licence, those left out apart where the library is the
// one that it was trained on.
std::string TrainedOnChapter(const CardFacts& facts);

// Clips that fail in the evaluation, with the force that their motion leaves
// unexplained (sim/import/quality.h).
std::string LimitationsChapter(const CardFacts& facts);

// The commands, and how to load the bundle from C and from Python.
std::string ReproduceChapter(const CardFacts& facts);
std::string LoadChapter(const CardFacts& facts);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_CARD_TEXT_H_
