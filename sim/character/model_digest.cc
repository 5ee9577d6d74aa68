#include "sim/character/model_digest.h"

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "common/digest.h"

namespace sinew::character {
namespace {

// Appends arrays with their lengths, so that no two models run together.
class Image {
 public:
  template <typename T>
  void Add(const T* values, int64_t count) {
    static_assert(std::is_arithmetic_v<T>);
    AddRaw(&count, sizeof(count));
    AddRaw(values, static_cast<size_t>(count) * sizeof(T));
  }
  void AddName(const mjModel& model, mjtObj type, int id) {
    const char* name = mj_id2name(&model, type, id);
    Add(name == nullptr ? "" : name,
        name == nullptr ? 0 : static_cast<int64_t>(std::strlen(name)));
  }

  std::string bytes;

 private:
  void AddRaw(const void* data, size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  }
};

void AddBodies(const mjModel& model, Image* image) {
  for (int i = 0; i < model.nbody; ++i) image->AddName(model, mjOBJ_BODY, i);
  image->Add(model.body_parentid, model.nbody);
  image->Add(model.body_pos, 3 * model.nbody);
  image->Add(model.body_quat, 4 * model.nbody);
  image->Add(model.body_ipos, 3 * model.nbody);
  image->Add(model.body_iquat, 4 * model.nbody);
  image->Add(model.body_mass, model.nbody);
  image->Add(model.body_inertia, 3 * model.nbody);
}

void AddJoints(const mjModel& model, Image* image) {
  for (int i = 0; i < model.njnt; ++i) image->AddName(model, mjOBJ_JOINT, i);
  image->Add(model.jnt_type, model.njnt);
  image->Add(model.jnt_bodyid, model.njnt);
  image->Add(model.jnt_pos, 3 * model.njnt);
  image->Add(model.jnt_axis, 3 * model.njnt);
  image->Add(model.jnt_limited, model.njnt);
  image->Add(model.jnt_range, 2 * model.njnt);
  image->Add(model.qpos0, model.nq);
  image->Add(model.dof_armature, model.nv);
}

void AddGeoms(const mjModel& model, Image* image) {
  for (int i = 0; i < model.ngeom; ++i) {
    if (model.geom_contype[i] == 0 && model.geom_conaffinity[i] == 0) continue;
    image->AddName(model, mjOBJ_GEOM, i);
    image->Add(&model.geom_type[i], 1);
    image->Add(&model.geom_bodyid[i], 1);
    image->Add(&model.geom_size[3 * i], 3);
    image->Add(&model.geom_pos[3 * i], 3);
    image->Add(&model.geom_quat[4 * i], 4);
  }
}

}  // namespace

std::string ModelDigest(const v1::Character& character, const mjModel& model) {
  Image image;
  const std::string text = SerializeDeterministically(character);
  image.Add(text.data(), static_cast<int64_t>(text.size()));
  AddBodies(model, &image);
  AddJoints(model, &image);
  AddGeoms(model, &image);
  return Sha256Hex(image.bytes);
}

}  // namespace sinew::character
