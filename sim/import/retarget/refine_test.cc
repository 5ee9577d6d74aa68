// The physics behind an import, each part against a second way: contact forces
// against balance, derivatives against finite differences, the refinement
// against what it promises.
#include "sim/import/retarget/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/import/retarget/contact_fit.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/quality.h"
#include "sim/import/retarget/refine_terms.h"
#include "sim/import/retarget/self_contact.h"
#include "sim/import/testing/humanoid_fixture.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class RefineTest : public testing::HumanoidFixture {
 protected:
  int nv() const { return dynamics_->model().nv; }
  double weight() const { return model_.weight(); }

  // The rest pose, its soles on the floor.
  VectorXd Standing() {
    VectorXd qpos = Eigen::Map<const VectorXd>(dynamics_->model().qpos0,
                                               dynamics_->model().nq);
    return OnFloor(qpos);
  }
  VectorXd OnFloor(VectorXd qpos) {
    qpos[2] -= Low(qpos);
    return qpos;
  }
  double Low(const VectorXd& qpos) {
    dynamics_->SetPose(qpos);
    return dynamics_->LowestHeight();
  }

  // Knees and hips bend and stretch once in a second, the body keeps its
  // height over the floor wrong by `floating`.
  ModelMotion Squat(double floating) {
    ModelMotion motion;
    motion.rate = 30;
    motion.loops = true;
    for (int t = 0; t < 30; ++t) {
      VectorXd qpos = Standing();
      const double bend = 0.15 * (1 - std::cos(2 * std::numbers::pi * t / 30));
      for (size_t j = 0; j < model_.joints.size(); ++j) {
        const std::string& name = model_.semantics[j].semantic;
        const int address = model_.joints[j].qpos_address;
        if (name.find("knee") != std::string::npos) qpos[address] = 2 * bend;
        if (name.find("hip_y") != std::string::npos) qpos[address] = -bend;
        if (name.find("ankle_y") != std::string::npos) qpos[address] = -bend;
      }
      motion.qpos.push_back(OnFloor(qpos));
      motion.qpos.back()[2] += floating;
    }
    return motion;
  }

  // That the slopes of the cost at `motion` are those of the equations.
  void ExpectGradient(const ModelMotion& original, const ModelMotion& motion,
                      const std::vector<int>& dofs) {
    const auto bearing = FindBearingPoints(
        dynamics_.get(), std::vector<bool>(motion.frames(), true), motion);
    RefineTerms terms(dynamics_.get(), original, bearing, RefineOptions());
    const RefineState state = terms.Begin(motion);
    NormalEquations equations = terms.MakeEquations();
    terms.Linearise(state, &equations);
    const auto moved = [&](int dof, double size) {
      std::vector<VectorXd> steps;
      for (int t = 0; t < motion.frames(); ++t) {
        steps.push_back(size * std::sin(1.7 * t + dof) *
                        VectorXd::Unit(nv(), dof));
      }
      return terms.Evaluate(terms.Moved(state, steps), state).cost;
    };
    for (const int dof : dofs) {
      double analytic = 0;
      for (int t = 0; t < motion.frames(); ++t) {
        analytic +=
            2 * std::sin(1.7 * t + dof) * equations.gradient()[t * nv() + dof];
      }
      const double slope = (moved(dof, 1e-6) - moved(dof, -1e-6)) / 2e-6;
      EXPECT_NEAR(analytic, slope, 0.02 * std::abs(slope) + 1e-3)
          << "dof " << dof;
    }
  }
};

TEST_F(RefineTest, TheFloorCarriesTheWeightOfWhoStands) {
  const VectorXd qpos = Standing();
  const VectorXd zero = VectorXd::Zero(nv());
  const VectorXd required = dynamics_->Inverse(qpos, zero, zero);
  EXPECT_NEAR(required[2], weight(), 1e-6 * weight());
  dynamics_->SetPose(qpos);

  const ContactFit fit =
      FitContacts(*dynamics_, FindContacts(*dynamics_), required);

  double up = 0;
  for (const ContactForce& force : fit.forces) {
    up += force.force.z();
    EXPECT_GE(force.force.z(), 0);
    EXPECT_LE(force.force.head<2>().lpNorm<1>(),
              kFriction * force.force.z() + 1e-9);
  }
  EXPECT_NEAR(up, weight(), 0.01 * weight());
  EXPECT_LT(fit.remainder.head<3>().norm(), 0.01 * weight());
  EXPECT_LT(fit.remainder.segment<3>(3).norm(), 0.01 * weight());
}

TEST_F(RefineTest, NothingButTheFloorCarriesWhoFloats) {
  VectorXd qpos = Standing();
  qpos[2] += 0.5;
  const VectorXd zero = VectorXd::Zero(nv());
  const VectorXd required = dynamics_->Inverse(qpos, zero, zero);
  dynamics_->SetPose(qpos);
  EXPECT_TRUE(FindContacts(*dynamics_).empty());
  const ContactFit fit = FitContacts(*dynamics_, {}, required);
  EXPECT_NEAR(fit.remainder[2], weight(), 1e-6 * weight());
}

TEST_F(RefineTest, FreeFallTakesNoForce) {
  VectorXd qacc = VectorXd::Zero(nv());
  qacc[2] = dynamics_->model().opt.gravity[2];
  const VectorXd force =
      dynamics_->Inverse(Standing(), VectorXd::Zero(nv()), qacc);
  EXPECT_NEAR(force.head<3>().norm(), 0, 1e-6 * weight());
}

TEST_F(RefineTest, ContactForceDerivativeAgreesWithFiniteDifferences) {
  const VectorXd qpos = Squat(0).qpos[9];
  dynamics_->SetPose(qpos);
  std::vector<ContactForce> forces;
  for (const Contact& contact : FindContacts(*dynamics_)) {
    forces.push_back({contact, Eigen::Vector3d(30, -20, 100)});
  }
  ASSERT_FALSE(forces.empty());
  const MatrixXd derivative = ContactForceDerivative(*dynamics_, forces);
  const auto generalised = [&](const VectorXd& at) {
    dynamics_->SetPose(at);
    VectorXd sum = VectorXd::Zero(nv());
    for (const ContactForce& force : forces) {
      const GroundPoint& point = model_.points[force.contact.point];
      sum += dynamics_
                 ->PointJacobian(point.body,
                                 dynamics_->LowestPoint(force.contact.point))
                 .transpose() *
             force.force;
    }
    return sum;
  };
  for (int i = 0; i < nv(); ++i) {
    VectorXd more = qpos, less = qpos;
    const VectorXd step = 1e-5 * VectorXd::Unit(nv(), i);
    const VectorXd back = -step;
    mj_integratePos(&dynamics_->model(), more.data(), step.data(), 1);
    mj_integratePos(&dynamics_->model(), less.data(), back.data(), 1);
    const VectorXd slope = (generalised(more) - generalised(less)) / 2e-5;
    EXPECT_NEAR((derivative.col(i) - slope).norm(), 0, 0.02) << "dof " << i;
  }
}

TEST_F(RefineTest, GradientAgreesWithFiniteDifferencesOfTheCost) {
  const ModelMotion original = Squat(0.004);
  ModelMotion motion = original;
  for (int t = 0; t < motion.frames(); ++t) motion.qpos[t][8] += 0.02 * t / 30;

  ExpectGradient(original, motion, {0, 2, 4, 9, 20, 27});
}

TEST_F(RefineTest, GradientAgreesWhereBodiesAreInOneAnother) {
  const ModelMotion original = Squat(0.004);
  ModelMotion motion = original;
  // Both upper arms against the chest.
  std::vector<int> dofs;
  for (size_t j = 0; j < model_.joints.size(); ++j) {
    const std::string& name = model_.semantics[j].semantic;
    if (name.find("shoulder_x") == std::string::npos) continue;
    dofs.push_back(model_.joints[j].dof_address);
    for (VectorXd& qpos : motion.qpos) {
      qpos[model_.joints[j].qpos_address] = -0.35;
    }
  }
  ASSERT_FALSE(dofs.empty());
  const SelfContacts self(model_);
  dynamics_->SetPose(motion.qpos[3]);
  ASSERT_GT(self.Deepest(dynamics_->data()), 0.02);
  dynamics_->SetPose(original.qpos[3]);
  ASSERT_LT(self.Deepest(dynamics_->data()), 0.001);

  ExpectGradient(original, motion, dofs);
}

TEST_F(RefineTest, MakesAFloatingMotionPhysicalWithoutChangingItMuch) {
  const ModelMotion original = Squat(0.01);
  const auto bearing = FindBearingPoints(
      dynamics_.get(), std::vector<bool>(original.frames(), true), original);

  const ModelMotion refined = RefineMotion(dynamics_.get(), bearing, original);

  const auto quality = [&](const ModelMotion& motion) {
    return MeasureQuality(dynamics_.get(), motion,
                          AnalyseMotion(dynamics_.get(), motion));
  };
  EXPECT_LT(quality(refined).residual_force_bodyweights(),
            0.5 * quality(original).residual_force_bodyweights());
  EXPECT_LT(quality(refined).residual_force_bodyweights(), 0.06);
  EXPECT_LT(quality(refined).floating_mean_m(), 0.003);
  EXPECT_LT(quality(refined).penetration_max_m(), 0.003);
  for (int t = 0; t < original.frames(); ++t) {
    VectorXd change(nv());
    mj_differentiatePos(&dynamics_->model(), change.data(), 1,
                        original.qpos[t].data(), refined.qpos[t].data());
    // The squat leans back too far to stand: the trunk has to follow.
    EXPECT_LT(change.cwiseAbs().maxCoeff(), 0.25) << "frame " << t;
  }
}

// Many squats along a curve, as a line and as a loop.
class RefineWindows : public RefineTest,
                      public ::testing::WithParamInterface<bool> {};

TEST_P(RefineWindows, JoinWithoutAKink) {
  ModelMotion original;
  original.rate = 30;
  original.loops = GetParam();
  original.cycle.x = 0.1;
  original.cycle.yaw = 0.2;
  const ModelMotion squat = Squat(0.005);
  constexpr int kFrames = 150;
  for (int t = 0; t < kFrames; ++t) {
    VectorXd qpos = squat.qpos[t % 30];
    qpos[0] += original.cycle.x * t / kFrames;
    qpos[8] += 0.02 * std::sin(2 * std::numbers::pi * t / 15);
    // Standing, the root is upright.
    qpos[3] = std::cos(original.cycle.yaw * t / kFrames / 2);
    qpos[6] = std::sin(original.cycle.yaw * t / kFrames / 2);
    original.qpos.push_back(qpos);
  }
  const auto bearing = FindBearingPoints(
      dynamics_.get(), std::vector<bool>(original.frames(), true), original);
  RefineOptions options;
  options.converged = 1e-9;
  const ModelMotion whole =
      RefineMotion(dynamics_.get(), bearing, original, options);
  options.window = 70;
  options.overlap = 30;

  const ModelMotion joined =
      RefineMotion(dynamics_.get(), bearing, original, options);

  ASSERT_EQ(joined.frames(), whole.frames());
  // Windows may end in another minimum than the whole; where they meet, nothing
  // may bend more than the whole does anywhere.
  const auto bend = [&](const ModelMotion& motion, int t) {
    VectorXd qvel, qacc;
    Rates(dynamics_->model(), motion, t, &qvel, &qacc);
    return qacc.cwiseAbs().maxCoeff();
  };
  double most = 0;
  for (int t = 0; t < whole.frames(); ++t) {
    most = std::max(most, bend(whole, t));
  }
  for (int t = 0; t < joined.frames(); ++t) {
    EXPECT_LT(bend(joined, t), 1.2 * most) << "frame " << t;
  }
  const auto floating = [&](const ModelMotion& motion) {
    return MeasureQuality(dynamics_.get(), motion,
                          AnalyseMotion(dynamics_.get(), motion))
        .floating_mean_m();
  };
  EXPECT_LT(floating(joined), 0.5 * floating(original));
}

INSTANTIATE_TEST_SUITE_P(LinesAndLoops, RefineWindows, ::testing::Bool(),
                         [](const auto& param) {
                           return param.param ? "Loop" : "Line";
                         });

TEST_F(RefineTest, FindsFlightAndMakesItBallistic) {
  // A hop: crouched still, then 0.5 s of flight whose capture floats along a
  // wrong curve, then still again.
  ModelMotion motion;
  motion.rate = 30;
  const VectorXd rest = Standing();
  constexpr int kStill = 12, kFlight = 15;
  for (int t = 0; t < 2 * kStill + kFlight; ++t) {
    VectorXd qpos = rest;
    const double s =
        static_cast<double>(t - kStill + 1) / (kFlight + 1);  // 0 to 1
    if (s > 0 && s < 1) qpos[2] += 1.0 * s * (1 - s);  // 0.25 m, should be 0.35
    motion.qpos.push_back(qpos);
  }

  const auto supported = FindSupport(dynamics_.get(), motion, 0);
  MakeFlightsBallistic(dynamics_.get(), supported, &motion);

  EXPECT_TRUE(supported[2]);
  EXPECT_TRUE(supported[kStill + kFlight + 5]);
  for (int t = kStill + 3; t < kStill + kFlight - 3; ++t) {
    EXPECT_FALSE(supported[t]) << t;
    const double fall = (motion.qpos[t - 1][2] - 2 * motion.qpos[t][2] +
                         motion.qpos[t + 1][2]) *
                        30 * 30;
    EXPECT_NEAR(fall, -9.81, 0.05) << t;
  }
}

}  // namespace
}  // namespace sinew::import
