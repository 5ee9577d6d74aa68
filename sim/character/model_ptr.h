#ifndef SINEW_SIM_CHARACTER_MODEL_PTR_H_
#define SINEW_SIM_CHARACTER_MODEL_PTR_H_

#include <mujoco/mujoco.h>

#include <memory>

namespace sinew::character {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;

struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MODEL_PTR_H_
