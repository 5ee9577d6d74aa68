#ifndef SINEW_SIM_MOTION_TESTING_SAMPLE_LIBRARY_H_
#define SINEW_SIM_MOTION_TESTING_SAMPLE_LIBRARY_H_

#include <memory>
#include <string>

#include "common/policy/safetensors.h"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/motion/library.h"

namespace sinew::motion::testing {

inline constexpr int kFrames = 12;
inline constexpr double kRate = 30;
inline constexpr double kTurn = 0.6;  // rad per cycle

struct Sample {
  v1::MotionLibrary manifest;
  TensorMap frames;
};

// One body with one joint and one foot that goes round an arc of radius 1 m
// about (5, 3); the clip "arc" loops and turns by kTurn each cycle, "once" is
// the same and does not loop. kFrames frames each at kRate.
Sample MakeSample();

// `name` below the test's temporary folder.
std::string Folder(const std::string& name);

// MakeSample by way of Save and Load.
std::unique_ptr<Library> SaveAndLoad(const std::string& name);

// The files of a good library, to be spoilt.
struct Files {
  std::string manifest, frames;
};
Files GoodFiles();

// A library in `folder` as large as `hours` of `clips` clips at 30 Hz of a body
// with 28 joints, 17 bodies and 2 feet. Its frames are a hole in the disk (all
// zero), so it takes no room, and Verify refuses it.
void MakeSparseLibrary(double hours, int clips, const std::string& folder);

}  // namespace sinew::motion::testing

#endif  // SINEW_SIM_MOTION_TESTING_SAMPLE_LIBRARY_H_
