#ifndef SINEW_TOOLS_ZOO_TRAINED_ON_H_
#define SINEW_TOOLS_ZOO_TRAINED_ON_H_

#include <string>

#include "tools/zoo/card_facts.h"

namespace sinew::zoo {

// The chapter of a model card about its data: clips by credit and licence, and
// by what the bundle says they were to training (deploy/bundle/clip_uses.h). Of
// a bundle that does not say, those that the library leaves out stand apart
// where it is the one that was trained on. Markdown that ends with a newline.
//
// Thread-safety: pure. Blocking: never. Errors: none.
std::string TrainedOnChapter(const CardFacts& facts);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_TRAINED_ON_H_
