#ifndef SINEW_LEARNER_DISTILLATION_TESTING_STUDENT_RECIPE_H_
#define SINEW_LEARNER_DISTILLATION_TESTING_STUDENT_RECIPE_H_

#include <string>

#include "common/config/recipe.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// Widths of the students in tests: observation, of which own, action, latent.
inline constexpr int kObservation = 6, kOwn = 4, kAction = 2, kLatent = 3;
inline constexpr int kHorizon = 8;

// A small student with a latent: 4 orders of 4 environments, 8 steps; 8
// sequences in a minibatch, two shards.
inline v1::Recipe StudentRecipe(const std::string& overrides = "") {
  v1::Recipe recipe;
  const std::string text =
      R"pb(
        format_version: 1
        name: "student"
        seed: 7
        task { action { placement: PLACEMENT_ABSOLUTE } }
        network {
          policy_hidden: [ 16 ]
          value_hidden: [ 4 ]
          last_layer_gain: 1
          latent {
            width: 3
            encoder_hidden: [ 16 ]
            prior_hidden: [ 16 ]
            decoder_hidden: [ 16 ]
            log_variance_low: -5
            log_variance_high: 2
          }
        }
        rollouts { environments: 16 horizon: 8 environments_per_order: 4 }
        distillation {
          teacher_action { placement: PLACEMENT_AROUND_NEXT_REFERENCE }
          form: FORM_PAPER
          learning_rate: 5e-3
          max_gradient_norm: 50
          minibatch: 64
          samples_per_insert: 8
          shards: 2
          kl_weight: 1e-3
          kl_weight_final: 1e-3
          continuity_weight: 1e-4
          memory { rows: 256 selector: SELECTOR_UNIFORM priority_exponent: 0.6 }
        }
      )pb" +
      overrides;
  EXPECT_TRUE(google::protobuf::TextFormat::MergeFromString(text, &recipe));
  return WithDefaults(recipe);
}

// The same without the bottleneck.
inline v1::Recipe PlainStudentRecipe(const std::string& overrides = "") {
  v1::Recipe recipe = StudentRecipe(overrides);
  recipe.mutable_network()->clear_latent();
  return recipe;
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_TESTING_STUDENT_RECIPE_H_
