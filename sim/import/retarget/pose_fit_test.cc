// The fit of poses: slopes against finite differences, the whole against what
// it promises.
#include "sim/import/retarget/pose_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/stop.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/retarget/ground.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/pose_terms.h"
#include "sim/import/retarget/source_track.h"
#include "sim/import/testing/humanoid_fixture.h"
#include "sim/import/testing/made_skeletons.h"

namespace sinew::import {
namespace {

using Eigen::VectorXd;

class PoseFitTest : public testing::HumanoidFixture {
 protected:
  PoseFitTest() {
    const SourceClip clip = testing::MadeClip({});
    track_ = *MakeRoleTrack(MakeTrack(clip, 30), clip.skeleton,
                            *DraftSkeletonMap(clip.skeleton, "draft"));
    map_ = *MakeBodyMap(track_, model_);
    motion_ = FitMotion(track_, map_, *model_.model);
    supported_ = PlaceOnFloor(dynamics_.get(), &motion_);
    wanted_ = ScaleSource(track_, map_, motion_, dynamics_.get());
  }

  // Shakes the feet by a centimetre from frame to frame.
  ModelMotion Shaken() {
    ModelMotion shaken = motion_;
    for (int t = 0; t < shaken.frames(); ++t) {
      shaken.qpos[t][0] += 0.01 * std::sin(2.5 * t);
      for (const ImportJoint& joint : model_.joints) {
        shaken.qpos[t][joint.qpos_address] +=
            0.02 * std::sin(2.5 * t + joint.dof_address);
      }
    }
    return shaken;
  }

  RoleTrack track_;
  BodyMap map_;
  ModelMotion motion_;
  std::vector<bool> supported_;
  ScaledSource wanted_;
};

TEST_F(PoseFitTest, SlopesAgreeWithFiniteDifferences) {
  const auto locks = FindLocks(supported_, motion_, dynamics_.get());
  PoseFitOptions options;
  // Heavy enough to be seen beside the points.
  options.rotation = options.limb_rotation = 4;
  const PoseTerms terms(track_, map_, wanted_, locks, motion_,
                        {.begin = 0, .frames = motion_.frames()},
                        dynamics_.get(), options);
  const ModelMotion at = Shaken();
  const int nv = model_.model->nv;
  const auto cost = [&](const ModelMotion& motion) {
    NormalEquations equations(motion.frames(), nv, /*ring=*/false);
    return terms.Linearise(motion.qpos, 0, &equations);
  };
  NormalEquations equations(at.frames(), nv, /*ring=*/false);
  terms.Linearise(at.qpos, 0, &equations);
  constexpr double kStep = 1e-6;
  for (const int t : {0, 17, at.frames() - 1}) {
    for (int i = 0; i < nv; i += 3) {
      VectorXd step = VectorXd::Zero(nv);
      step[i] = kStep;
      ModelMotion more = at, less = at;
      mj_integratePos(model_.model, more.qpos[t].data(), step.data(), 1);
      mj_integratePos(model_.model, less.qpos[t].data(), step.data(), -1);
      const double numeric = (cost(more) - cost(less)) / (4 * kStep);
      EXPECT_NEAR(equations.Gradient(t)[i], numeric,
                  1e-3 + 0.02 * std::abs(numeric))
          << t << " " << i;
    }
  }
}

// Largest differences of hinges and root place, rad and m; `from_ends` frames
// at either end apart.
double Apart(const ModelMotion& a, const ModelMotion& b, int from_ends = 0) {
  double apart = 0;
  for (int t = from_ends; t < a.frames() - from_ends; ++t) {
    apart = std::max(apart, (a.qpos[t] - b.qpos[t]).cwiseAbs().maxCoeff());
  }
  return apart;
}

// The largest second difference that a fit has changed a motion by.
double Kink(const ModelMotion& before, const ModelMotion& after, bool around) {
  const int frames = before.frames();
  const auto change = [&](int t) -> VectorXd {
    const int at = (t + frames) % frames;
    return (after.qpos[at] - before.qpos[at])
        .tail(after.qpos[at].size() - 7);  // hinges
  };
  double kink = 0;
  for (int t = around ? 0 : 1; t < frames - (around ? 0 : 1); ++t) {
    const VectorXd bend = change(t - 1) - 2 * change(t) + change(t + 1);
    kink = std::max(kink, bend.cwiseAbs().maxCoeff());
  }
  return kink;
}

struct Windows {
  const char* name;
  bool loops;
  int window, overlap;
};

class PoseFitWindows : public PoseFitTest,
                       public ::testing::WithParamInterface<Windows> {};

TEST_P(PoseFitWindows, GiveWhatTheWholeGives) {
  motion_.loops = GetParam().loops;
  motion_.cycle = {};
  const auto locks = FindLocks(supported_, motion_, dynamics_.get());
  const ModelMotion shaken = Shaken();
  PoseFitOptions options;
  const ModelMotion whole =
      FitPoses(track_, map_, wanted_, locks, shaken, dynamics_.get(), options);
  options.window = GetParam().window;
  options.overlap = GetParam().overlap;
  ASSERT_GT(shaken.frames(), 2 * options.window);

  const ModelMotion parts =
      FitPoses(track_, map_, wanted_, locks, shaken, dynamics_.get(), options);

  // Around a seam the whole is no oracle: its equations couple nothing over it,
  // so that it is far from the minimum there after so few steps.
  const int seam = GetParam().loops ? 12 : 0;
  // What is changed is of the order of 0.02 rad and 0.01 m.
  EXPECT_GT(Apart(whole, shaken, seam), 0.01);
  EXPECT_LT(Apart(whole, parts, seam), 0.006);
  EXPECT_LT(Kink(shaken, parts, /*around=*/false),
            1.2 * Kink(shaken, whole, /*around=*/false));
}

// The made clip has 61 frames. Where windows end relative to the seam differs.
INSTANTIATE_TEST_SUITE_P(LinesAndLoops, PoseFitWindows,
                         ::testing::Values(Windows{"line", false, 25, 8},
                                           Windows{"loop", true, 25, 8},
                                           Windows{"short_last", false, 26, 8},
                                           Windows{"past_seam", true, 26, 8},
                                           Windows{"on_seam", true, 22, 9}),
                         [](const auto& info) { return info.param.name; });

// The frames of a loop, `by` later.
template <typename Rows>
Rows Turned(const Rows& rows, int by) {
  Rows turned = rows;
  std::rotate(turned.begin(), turned.begin() + by, turned.end());
  return turned;
}

class PoseFitLoops : public PoseFitTest,
                     public ::testing::WithParamInterface<Windows> {};

TEST_P(PoseFitLoops, DoNotDependOnWhereTheyBegin) {
  motion_.loops = true;
  motion_.cycle = {};
  const auto locks = FindLocks(supported_, motion_, dynamics_.get());
  const ModelMotion shaken = Shaken();
  PoseFitOptions options;
  options.window = GetParam().window;
  options.overlap = GetParam().overlap;
  const ModelMotion parts =
      FitPoses(track_, map_, wanted_, locks, shaken, dynamics_.get(), options);

  // As a line that begins half a cycle later, the seam is in the middle.
  const int half = shaken.frames() / 2;
  RoleTrack track = track_;
  track.rotation = Turned(track.rotation, half);
  track.position = Turned(track.position, half);
  ModelMotion later = shaken;
  later.loops = false;
  later.qpos = Turned(later.qpos, half);
  const ModelMotion whole =
      FitPoses(track, map_, Turned(wanted_, half), Turned(locks, half), later,
               dynamics_.get(), PoseFitOptions());

  ModelMotion turned = parts;
  turned.qpos = Turned(turned.qpos, half);
  // Its own ends are free.
  EXPECT_LT(Apart(whole, turned, /*from_ends=*/12), 0.006);
}

INSTANTIATE_TEST_SUITE_P(Ends, PoseFitLoops,
                         ::testing::Values(Windows{"before", true, 25, 8},
                                           Windows{"past", true, 26, 8},
                                           Windows{"on", true, 22, 9}),
                         [](const auto& info) { return info.param.name; });

TEST_F(PoseFitTest, ChangesNothingOnceItIsToStop) {
  StopSource source;
  source.request_stop();
  PoseFitOptions options;
  options.stop = source.get_token();
  const ModelMotion shaken = Shaken();

  const ModelMotion stopped = FitPoses(
      track_, map_, wanted_, FindLocks(supported_, motion_, dynamics_.get()),
      shaken, dynamics_.get(), options);

  EXPECT_LT(Apart(stopped, shaken), 1e-12);
}

TEST_F(PoseFitTest, HandsAreWantedWhereTheSourceHasThemAsFarAsArmsReach) {
  int reached = 0;
  for (int t = 0; t < motion_.frames(); ++t) {
    const auto wanted = [&](const std::string& role) {
      return wanted_[t][track_.Find(role)];
    };
    const auto source = [&](const std::string& role) {
      return track_.position[t][track_.Find(role)];
    };
    for (const std::string side : {"left", "right"}) {
      const Eigen::Vector3d shoulder = wanted(side + "_shoulder");
      const Eigen::Vector3d elbow = wanted(side + "_elbow");
      const Eigen::Vector3d hand = wanted(side + "_wrist");
      const Eigen::Vector3d place =
          (wanted("left_hip") + wanted("right_hip")) / 2 +
          map_.scale * (source(side + "_wrist") -
                        (source("left_hip") + source("right_hip")) / 2);
      const double upper = (elbow - shoulder).norm();
      const double lower = (hand - elbow).norm();
      // The bones of the humanoid: upper arm and forearm.
      const auto place_of = [&](const std::string& role) {
        return PointPlace(map_, map_.points[map_.FindPoint(track_.Find(role))],
                          *dynamics_);
      };
      dynamics_->SetPose(motion_.qpos[t]);
      EXPECT_NEAR(
          upper,
          (place_of(side + "_elbow") - place_of(side + "_shoulder")).norm(),
          1e-9);
      EXPECT_NEAR(
          lower, (place_of(side + "_wrist") - place_of(side + "_elbow")).norm(),
          1e-9);
      const double off = (hand - place).norm();
      reached += off < 1e-9;
      if (off < 1e-9) continue;
      // A straight arm that points there.
      EXPECT_NEAR((hand - shoulder).norm(), upper + lower, 1e-9);
      EXPECT_NEAR((place - shoulder).norm(), upper + lower + off, 1e-9);
    }
  }
  EXPECT_GT(reached, 0);
}

TEST_F(PoseFitTest, ElbowsOfStraightArmsBendAsTheModelDoesAndDoNotJump) {
  // Arms of the source straight, or bent to either side by less than can be
  // told, and too short for the model's.
  for (int t = 0; t < motion_.frames(); ++t) {
    for (const std::string side : {"left", "right"}) {
      std::vector<Eigen::Vector3d>& source = track_.position[t];
      const Eigen::Vector3d shoulder = source[track_.Find(side + "_shoulder")];
      Eigen::Vector3d& hand = source[track_.Find(side + "_wrist")];
      hand = shoulder + 0.8 * (hand - shoulder);
      source[track_.Find(side + "_elbow")] =
          (shoulder + hand) / 2 +
          Eigen::Vector3d(0.008 * std::sin(1.0 * t), 0, 0);
    }
  }
  const ScaledSource wanted =
      ScaleSource(track_, map_, motion_, dynamics_.get());
  for (int t = 0; t < motion_.frames(); ++t) {
    for (const std::string side : {"left", "right"}) {
      const auto out = [&](int frame) -> Eigen::Vector3d {
        const auto at = [&](const std::string& role) {
          return wanted[frame][track_.Find(side + role)];
        };
        return at("_elbow") - (at("_shoulder") + at("_wrist")) / 2;
      };
      EXPECT_GT(out(t).norm(), 0.05) << t << " " << side;
      // Elbows go with the arm, not from one side of it to the other.
      if (t == 0) continue;
      EXPECT_GT(out(t).normalized().dot(out(t - 1).normalized()), 0.7)
          << t << " " << side;
    }
  }
}

TEST_F(PoseFitTest, AShakenMotionIsCalmedAndItsFeetStand) {
  const ModelMotion shaken = Shaken();
  const auto locks = FindLocks(supported_, shaken, dynamics_.get());
  int standing = 0;
  for (const auto& frame : locks) standing += static_cast<int>(frame.size());
  ASSERT_GT(standing, 0);
  const ModelMotion fitted =
      FitPoses(track_, map_, wanted_, locks, shaken, dynamics_.get());
  const auto off = [&](const Lock& lock) {
    return (dynamics_->LowestPoint(lock.point).head<2>() - lock.place).norm();
  };
  double before = 0, after = 0;
  for (int t = 0; t < fitted.frames(); ++t) {
    for (const Lock& lock : locks[t]) {
      dynamics_->SetPose(shaken.qpos[t]);
      before += off(lock);
      dynamics_->SetPose(fitted.qpos[t]);
      after += off(lock);
    }
  }
  EXPECT_LT(after, 0.2 * before);
}

TEST_F(PoseFitTest, AnArmInTheBodyIsTakenOut) {
  ModelMotion motion = motion_;
  // Both upper arms against the chest.
  for (size_t j = 0; j < model_.semantics.size(); ++j) {
    if (model_.semantics[j].semantic.find("shoulder_x") == std::string::npos) {
      continue;
    }
    for (VectorXd& qpos : motion.qpos) {
      qpos[model_.joints[j].qpos_address] = -0.35;
    }
  }
  const SelfContacts self(model_);
  const auto deepest = [&](const ModelMotion& m) {
    double depth = 0;
    for (const VectorXd& qpos : m.qpos) {
      dynamics_->SetPose(qpos);
      depth = std::max(depth, self.Deepest(dynamics_->data()));
    }
    return depth;
  };
  ASSERT_GT(deepest(motion), 0.02);
  const ScaledSource wanted =
      ScaleSource(track_, map_, motion, dynamics_.get());
  const ModelMotion fitted = FitPoses(
      track_, map_, wanted, FindLocks(supported_, motion, dynamics_.get()),
      motion, dynamics_.get());
  EXPECT_LT(deepest(fitted), 0.5 * deepest(motion));
}

}  // namespace
}  // namespace sinew::import
