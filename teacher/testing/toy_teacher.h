#ifndef SINEW_TEACHER_TESTING_TOY_TEACHER_H_
#define SINEW_TEACHER_TESTING_TOY_TEACHER_H_

#include <cstdint>
#include <vector>

#include "teacher/client/annotator.h"
#include "teacher/teacher_policy.h"

namespace sinew::teacher::testing {

// Untrained teachers, real in everything but skill. Functions abort with a
// message on any error.

// A tracking policy of 21 observations and 3 actions: joints "a" (range +-1),
// "b" (not limited, an action scale of its own) and "c".
TeacherPolicy MakeToyTeacher(uint64_t seed = 1);

// The same joints under a student with a latent of width 2, whose first 9
// observations are the body's own (common/policy/latent_builder.h).
TeacherPolicy MakeToyStudent();

// Random rows, a function of the seed.
struct ToyRows {
  std::vector<float> observations;
  std::vector<double> bases;

  Rows rows() const { return {.observations = observations, .bases = bases}; }
};
ToyRows MakeToyRows(int64_t rows, uint64_t seed = 1);

}  // namespace sinew::teacher::testing

#endif  // SINEW_TEACHER_TESTING_TOY_TEACHER_H_
