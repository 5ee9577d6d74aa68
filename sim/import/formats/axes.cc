#include "sim/import/formats/axes.h"

#include "common/check.h"

namespace sinew::import {

Eigen::Quaterniond ToZUp(char up_axis) {
  switch (up_axis) {
    case 'x':  // x' = y, y' = z, z' = x: 240 degrees about (1, 1, 1)
      return Eigen::Quaterniond(0.5, -0.5, -0.5, -0.5);
    case 'y':  // x' = z, y' = x, z' = y: 120 degrees about (1, 1, 1)
      return Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);
    default:
      SINEW_CHECK(up_axis == 'z') << "up axis " << up_axis;
      return Eigen::Quaterniond::Identity();
  }
}

}  // namespace sinew::import
