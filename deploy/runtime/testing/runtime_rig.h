#ifndef SINEW_DEPLOY_RUNTIME_TESTING_RUNTIME_RIG_H_
#define SINEW_DEPLOY_RUNTIME_TESTING_RUNTIME_RIG_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deploy/bundle/bundle.h"
#include "deploy/runtime/runtime.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime::testing {

// A runtime of a toy bundle that observes blocks 1 to 5, two frames ahead, with
// velocity feed-forward; `edit` changes that task before the bundle is written.
// Aborts with a message on any error.
struct RuntimeRig {
  explicit RuntimeRig(
      const std::function<void(v1::Task&)>& edit = [](v1::Task&) {},
      world::testing::ToyClips clips = world::testing::ToyClips::kStanding);

  // Folder of the toy's motion library.
  std::string library() const;

  world::testing::ToyWorld toy;
  bundle::BundleContent content;
  std::unique_ptr<Runtime> runtime;
  std::vector<double> target;
};

}  // namespace sinew::runtime::testing

#endif  // SINEW_DEPLOY_RUNTIME_TESTING_RUNTIME_RIG_H_
