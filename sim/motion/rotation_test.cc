#include "sim/motion/rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sinew::motion {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

const Vector3d kVectors[] = {{0, 0, 0},   {1e-9, 0, -2e-9}, {0.3, -0.2, 0.9},
                             {0, 3.0, 0}, {-1.2, 1.9, 0.7}, {0, 0, -3.1}};

TEST(Rotation, ExpAgreesWithAngleAndAxisAndLogTurnsItBack) {
  for (const Vector3d& r : kVectors) {
    const Quaterniond expected(Eigen::AngleAxisd(
        r.norm(), r.norm() > 0 ? r.normalized() : Vector3d::UnitX()));
    EXPECT_NEAR(AngleBetween(Exp(r), expected), 0, 1e-12);
    EXPECT_NEAR((Log(Exp(r)) - r).norm(), 0, 1e-9);
    Quaterniond negative = Exp(r);
    negative.coeffs() *= -1;
    EXPECT_NEAR((Log(negative) - r).norm(), 0, 1e-9);
  }
}

TEST(Rotation, ArraysAreWxyz) {
  const double wxyz[4] = {0.5, 0.5, -0.5, 0.5};
  const Quaterniond q = FromWxyz(wxyz);
  EXPECT_EQ(q.w(), 0.5);
  EXPECT_EQ(q.y(), -0.5);
  float back[4];
  ToWxyz(q, back);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(back[i], wxyz[i]);
}

TEST(Rotation, InverseRightJacobianIsTheDerivativeOfLog) {
  constexpr double kStep = 1e-6;
  for (const Vector3d& r : {kVectors[1], kVectors[2], kVectors[4]}) {
    const Eigen::Matrix3d m = InverseRightJacobian(r);
    for (int i = 0; i < 3; ++i) {
      const Vector3d w = kStep * Vector3d::Unit(i);
      const Vector3d slope =
          (Log(Exp(r) * Exp(w)) - Log(Exp(r) * Exp(-w))) / (2 * kStep);
      EXPECT_NEAR((m.col(i) - slope).norm(), 0, 1e-6);
      const Vector3d parent =
          (Log(Exp(w) * Exp(r)) - Log(Exp(-w) * Exp(r))) / (2 * kStep);
      EXPECT_NEAR((m.transpose().col(i) - parent).norm(), 0, 1e-6);
    }
  }
}

TEST(Rotation, SlerpGoesTheShortWayAtConstantSpeed) {
  const Quaterniond a = Exp({0.1, 0.2, 0.3});
  Quaterniond b = a * Exp({0, 0, 1.2});
  b.coeffs() *= -1;
  EXPECT_NEAR(AngleBetween(Slerp(a, b, 0.25), a * Exp({0, 0, 0.3})), 0, 1e-9);
  EXPECT_NEAR(AngleBetween(Slerp(a, b, 1), b), 0, 1e-9);
}

TEST(Rotation, CentralVelocityIsExactAtConstantSpeedAndInTheWorldsFrame) {
  const Vector3d rate(1, -2, 0.5);
  const Quaterniond middle = Exp({0.4, 1, -0.3});
  constexpr double kDt = 1.0 / 30;
  const Vector3d found = CentralAngularVelocity(
      Exp(-kDt * rate) * middle, middle, Exp(kDt * rate) * middle, kDt);
  EXPECT_NEAR((found - rate).norm(), 0, 1e-9);
}

TEST(Rotation, YawIsTheTurnAboutTheVertical) {
  for (const double yaw : {-3.0, -0.5, 0.0, 2.0}) {
    EXPECT_NEAR(Yaw(YawRotation(yaw)), yaw, 1e-12);
    EXPECT_NEAR(Yaw(YawRotation(yaw) * Exp({0, 1.3, 0})), yaw, 1e-12);
  }
}

TEST(Rotation, UnwrapTakesTheNearestTurn) {
  EXPECT_NEAR(Unwrap(-3, 3.1), 2 * kPi - 3, 1e-12);
  EXPECT_NEAR(Unwrap(7, 0), 7 - 2 * kPi, 1e-12);
  const Quaterniond q = Exp({0, 0, 3});
  Quaterniond negative = q;
  negative.coeffs() *= -1;
  EXPECT_TRUE(Near(negative, q).isApprox(q));
}

}  // namespace
}  // namespace sinew::motion
