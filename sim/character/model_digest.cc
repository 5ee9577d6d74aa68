#include "sim/character/model_digest.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "common/digest.h"

namespace sinew::character {
namespace {

// Appends raw numbers, each array preceded by its length.
class Image {
 public:
  void Add(const mjtNum* values, int64_t count) {
    absl::StrAppend(&bytes_, count, ":");
    bytes_.append(reinterpret_cast<const char*>(values),
                  static_cast<size_t>(count) * sizeof(mjtNum));
  }
  void Add(const int* values, int64_t count) {
    absl::StrAppend(&bytes_, count, ":");
    bytes_.append(reinterpret_cast<const char*>(values),
                  static_cast<size_t>(count) * sizeof(int));
  }
  void Add(const char* name) {
    absl::StrAppend(&bytes_, name == nullptr ? "" : name, "\n");
  }
  void Add(absl::string_view text) { absl::StrAppend(&bytes_, text, "\n"); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::string BodyDigest(const mjModel& model, int floor_geom,
                       absl::string_view character_text) {
  Image image;
  image.Add(character_text);
  for (int i = 0; i < model.nbody; ++i) {
    image.Add(mj_id2name(&model, mjOBJ_BODY, i));
  }
  image.Add(model.body_parentid, model.nbody);
  image.Add(model.body_pos, 3 * model.nbody);
  image.Add(model.body_quat, 4 * model.nbody);
  image.Add(model.body_ipos, 3 * model.nbody);
  image.Add(model.body_iquat, 4 * model.nbody);
  image.Add(model.body_mass, model.nbody);
  image.Add(model.body_inertia, 3 * model.nbody);
  for (int i = 0; i < model.njnt; ++i) {
    image.Add(mj_id2name(&model, mjOBJ_JOINT, i));
  }
  image.Add(model.jnt_type, model.njnt);
  image.Add(model.jnt_pos, 3 * model.njnt);
  image.Add(model.jnt_axis, 3 * model.njnt);
  image.Add(model.jnt_range, 2 * model.njnt);
  image.Add(model.dof_armature, model.nv);
  image.Add(model.qpos0, model.nq);
  for (int i = 0; i < model.ngeom; ++i) {
    if (i == floor_geom) continue;
    image.Add(model.geom_type + i, 1);
    image.Add(model.geom_bodyid + i, 1);
    image.Add(model.geom_size + 3 * i, 3);
    image.Add(model.geom_pos + 3 * i, 3);
    image.Add(model.geom_quat + 4 * i, 4);
  }
  return Sha256Hex(image.bytes());
}

}  // namespace sinew::character
