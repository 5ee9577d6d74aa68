#ifndef SINEW_SIM_WORLD_TESTING_LIBRARY_MAKER_H_
#define SINEW_SIM_WORLD_TESTING_LIBRARY_MAKER_H_

#include <mujoco/mujoco.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "proto/sinew/v1/motion.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world::testing {

// Makes a library, at 30 Hz, out of states of a character's model.
//
//   LibraryMaker maker(character);
//   maker.BeginClip(info); maker.AddFrame(data, contact); ... x frames
//   auto library = maker.Make(folder);
//
// The feed-forward torque of a joint is 10 Nm/rad times its position, made up
// so that it is not zero. Aborts with a message on any error.
class LibraryMaker {
 public:
  // The character must outlive the maker.
  explicit LibraryMaker(const character::Character& character);

  // Name, loop and cycle of `info` are used.
  void BeginClip(const v1::ClipInfo& info);
  // `data` is forwarded (mj_forward); `contact` holds for all feet.
  void AddFrame(const mjData* data, bool contact);

  // Writes the library into `folder` and loads it.
  std::unique_ptr<const motion::Library> Make(const std::string& folder) const;

 private:
  void Add(const std::string& name, const mjtNum* values, int count);
  TensorMap Frames() const;

  const character::Character& character_;
  v1::MotionLibrary manifest_;
  std::map<std::string, std::vector<float>> values_;
};

// A new folder below the test's temporary folder.
std::string NewFolder();

}  // namespace sinew::world::testing

#endif  // SINEW_SIM_WORLD_TESTING_LIBRARY_MAKER_H_
