#ifndef SINEW_LEARNER_UPDATE_WIDENING_H_
#define SINEW_LEARNER_UPDATE_WIDENING_H_

#include <functional>
#include <set>
#include <string>

#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// Networks whose hidden layers are wider than those of the network that they
// begin with, and that compute the same: units that are new keep their initial
// weights for what they read, and nothing that was there reads them (weights of
// 0), so that gradients find them but the function is as it was.
//
// Thread-safety: pure, const. Ownership: copies names. Blocking: never.

class HiddenWidths {
 public:
  // Of all of its graphs together: a width counts as hidden if, wherever it is
  // used, it is the width of a LINEAR whose values go through one element-wise
  // activation into other LINEARs and nowhere else.
  explicit HiddenWidths(const v1::PolicyGraph& graph);

  // Whether parameter `name` of shape `wide` can hold one of shape `narrow`:
  // no extent is smaller, and those that are larger are hidden widths.
  bool CanWiden(absl::string_view name, const HostTensor& narrow,
                const HostTensor& wide) const;

 private:
  // Parameters whose extent 0, and extent 1, is another width than that.
  std::set<std::string, std::less<>> fixed_rows_;
  std::set<std::string, std::less<>> fixed_columns_;
};

// Writes `narrow` into the first rows and columns of `wide`, 0 into the other
// columns of those rows. Both float32, of one rank, 1 or 2. Precondition:
// CanWiden.
void Widen(const HostTensor& narrow, HostTensor& wide);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_WIDENING_H_
