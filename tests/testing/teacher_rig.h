#ifndef SINEW_TESTS_TESTING_TEACHER_RIG_H_
#define SINEW_TESTS_TESTING_TEACHER_RIG_H_

#include <memory>
#include <string>

#include "common/files.h"
#include "common/subprocess.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {

// Teachers and their students, on a training rig.

// Of a run with a teacher; without a bottleneck.
inline TrainingRig::Arguments Taught(const std::string& teacher,
                                     const TrainingRig::Arguments& more = {}) {
  TrainingRig::Arguments arguments = {
      "--set", "task.action.placement=absolute",
      "--set", "task.action.clip=100",
      "--set", "distillation.minibatch=32",
      "--set", "distillation.samples_per_insert=2",
      "--set", "distillation.memory.rows=128"};
  if (!teacher.empty()) {
    arguments.insert(arguments.end(), {"--teacher", teacher});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// A run of two iterations; its bundle.
inline std::string MakeTeacher(const TrainingRig& rig,
                               const std::string& name = "teacher",
                               const TrainingRig::Arguments& more = {}) {
  rig.MustRun(name, rig.Train(name, 2, more));
  return JoinPath(rig.Path(name), "bundle");
}

// `sinew teacher` of a bundle, and where it listens.
struct Served {
  Served(const TrainingRig& rig, const std::string& name,
         const std::string& bundle, const std::string& listen = "127.0.0.1:0")
      : process(rig.Start(name, {"teacher", "--bundle", bundle, "--listen",
                                 listen, "--threads", "1"})),
        address(rig.AwaitAddress(*process, name)) {}

  std::unique_ptr<Subprocess> process;
  std::string address;
};

// What the run's bundle says it was trained on, but for how long that took.
inline v1::BundleProvenance ProvenanceOf(const TrainingRig& rig,
                                         const std::string& run) {
  v1::BundleProvenance provenance =
      bundle::ReadBundle(JoinPath(rig.Path(run), "bundle"))
          .value()
          .manifest.provenance();
  provenance.clear_train_seconds();
  return provenance;
}

}  // namespace sinew::tests

#endif  // SINEW_TESTS_TESTING_TEACHER_RIG_H_
