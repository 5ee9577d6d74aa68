#ifndef SINEW_TOOLS_TEACHER_READ_TEACHER_H_
#define SINEW_TOOLS_TEACHER_READ_TEACHER_H_

#include <string>

#include "absl/status/statusor.h"
#include "deploy/bundle/bundle.h"
#include "teacher/teacher_policy.h"

namespace sinew::teacher {

// What a teacher needs of a bundle.
TeacherPolicy PolicyOf(const bundle::Bundle& bundle);

// The same of a bundle's folder, checked as ReadBundle does, with its errors.
// Blocks on the disk.
absl::StatusOr<TeacherPolicy> ReadTeacher(const std::string& bundle_directory);

}  // namespace sinew::teacher

#endif  // SINEW_TOOLS_TEACHER_READ_TEACHER_H_
