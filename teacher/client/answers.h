#ifndef SINEW_TEACHER_CLIENT_ANSWERS_H_
#define SINEW_TEACHER_CLIENT_ANSWERS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::teacher {

// What a client sends and believes. Pure; `peer` begins every message.

// Rows [first, first + count) as a request to a teacher of this description.
v1::AnnotateRequest MakeRequest(const v1::DescribeTeacherResponse& teacher,
                                const Rows& rows, int64_t first, int64_t count);

// Puts the answer to `count` rows into `targets` and `spread` [A]; nothing of
// the two means anything on errors. FAILED_PRECONDITION: of another build or
// CPU class than the teacher's. DATA_LOSS: sizes that do not fit, numbers that
// are not finite, negative spread.
absl::Status ReadAnswer(const v1::DescribeTeacherResponse& teacher,
                        const v1::AnnotateResponse& answer,
                        const std::string& peer, absl::Span<double> targets,
                        absl::Span<double> spread);

// FAILED_PRECONDITION: a description without bundle, or with widths and rows
// that no teacher has.
absl::Status CheckDescription(const v1::DescribeTeacherResponse& teacher,
                              const std::string& peer);

// FAILED_PRECONDITION naming both peers, field and values: whatever their
// answers depend on differs (bundle, build, CPU class, character, law, blocks,
// widths, control rate).
absl::Status CheckAlike(const v1::DescribeTeacherResponse& expected,
                        const std::string& expected_peer,
                        const v1::DescribeTeacherResponse& found,
                        const std::string& found_peer);

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_ANSWERS_H_
