#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FILES_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FILES_H_

#include <string>

namespace sinew::import::testing {

// Files in the dialects of well-known collections, made by formula.

// A skeleton with the bones, axes and degrees of freedom of CMU's, and rounded
// lengths of our own.
std::string MadeAsf();

// A motion of it: walks along z and swings its legs.
std::string MadeAmc(int frames);

// LaFAN1's dialect: 22 joints, rotations ZYX, centimetres, y up, 30 frames per
// second, and a rest pose that lies along x: a person whose hips are at
// (10, 92, 5) cm, who stands upright in every frame and walks along z.
std::string MadeLafanBvh(int frames);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FILES_H_
