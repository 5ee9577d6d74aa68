#include "sim/world/foot_contact.h"

namespace sinew::world {

void ReadFootContacts(const character::Character& character, mjData* data,
                      absl::Span<float> out) {
  mj_kinematics(character.model(), data);
  for (size_t f = 0; f < out.size(); ++f) {
    out[f] = 0;
    for (int geom : character.foot_geoms()[f]) {
      const double distance =
          mj_geomDistance(character.model(), data, character.floor_geom(), geom,
                          2 * kContactDistance, nullptr);
      if (distance < kContactDistance) out[f] = 1;
    }
  }
}

}  // namespace sinew::world
