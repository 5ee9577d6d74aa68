#ifndef SINEW_SIM_IMPORT_TESTING_HUMANOID_FIXTURE_H_
#define SINEW_SIM_IMPORT_TESTING_HUMANOID_FIXTURE_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/import_model.h"

namespace sinew::import::testing {

// The humanoid as retargeting and editing see it.
class HumanoidFixture : public ::testing::Test {
 protected:
  HumanoidFixture() {
    auto loaded = character::Character::Load("humanoid", v1::Physics());
    EXPECT_THAT(loaded, sinew::testing::IsOk());
    character_ = *std::move(loaded);
    model_ = MakeImportModel(*character_);
    dynamics_ = std::make_unique<Dynamics>(model_);
  }

  std::unique_ptr<const character::Character> character_;
  ImportModel model_;
  std::unique_ptr<Dynamics> dynamics_;
};

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_TESTING_HUMANOID_FIXTURE_H_
