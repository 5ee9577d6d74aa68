#ifndef SINEW_SIM_IMPORT_FORMATS_AXES_H_
#define SINEW_SIM_IMPORT_FORMATS_AXES_H_

#include <Eigen/Geometry>

namespace sinew::import {

// The turn from a world with `up_axis` ('x', 'y' or 'z') up to one with z up
// by a cyclic change of the axes: from y up, z' = y, x' = z, y' = x.
// Precondition: one of the three.
Eigen::Quaterniond ToZUp(char up_axis);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_AXES_H_
