#ifndef SINEW_SIM_IMPORT_TESTING_MADE_SKELETONS_H_
#define SINEW_SIM_IMPORT_TESTING_MADE_SKELETONS_H_

#include <string>

#include "sim/import/formats/source_clip.h"

namespace sinew::import::testing {

// How a made skeleton is spelt and at rest.
struct SkeletonStyle {
  // Angle of the arms from hanging in the rest pose, rad: 0 down, pi/2 a T.
  double arms = 0;
  // Angle that the legs of the rest pose are spread to each side, rad.
  double legs = 0;
  // Heading of the rest pose, rad: 0 looks along +x.
  double heading = 0;
  // The rest pose lies on its back instead of standing.
  bool lies = false;
  double metres_per_unit = 1;
  // Names with their side behind ("UpLeg_L") instead of before ("LeftUpLeg").
  bool side_behind = false;
  // Joints between spine and chest that turn by a part of its rotation each.
  int extra_spine = 0;
};

// A person of a made skeleton, 1.7 m tall, who shifts weight, bends the knees,
// swings the arms and twists the trunk for two seconds at 60 frames per second,
// feet on the floor. The same motion in the world for every style.
SourceClip MadeClip(const SkeletonStyle& style);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_TESTING_MADE_SKELETONS_H_
