// Students that learn from mirror images as well, by the real program: on the
// humanoid, since the toy body has no left and right.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/import/testing/made_clips.h"
#include "tests/testing/teacher_rig.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A library of one made clip, and a policy of two iterations on it.
class MirrorTest : public ::testing::Test {
 protected:
  MirrorTest() {
    const std::string clip = rig_.Path("march.txt");
    EXPECT_THAT(WriteFileAtomically(clip, import::testing::MarchJson()),
                IsOk());
    rig_.MustRun("import", {"motion", "import", "--out", Library(), "--no-html",
                            "--quiet", clip});
    rig_.MustRun("teacher", Train("teacher", 2,
                                  {"--recipe", "track_clip", "--set",
                                   "ppo.minibatch=32"}));
  }

  std::string Library() const { return rig_.Path("march"); }

  TrainingRig::Arguments Train(const std::string& run, int iterations,
                               const TrainingRig::Arguments& more) const {
    TrainingRig::Arguments arguments = {"train",
                                        "--motions",
                                        Library(),
                                        "--run",
                                        rig_.Path(run),
                                        "--iterations",
                                        std::to_string(iterations),
                                        "--set",
                                        "rollouts.environments=8",
                                        "--set",
                                        "rollouts.environments_per_order=4",
                                        "--set",
                                        "rollouts.horizon=8",
                                        "--set",
                                        "evaluation.starts=1",
                                        "--set",
                                        "evaluation.seconds=0.2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  // Of a student of the teacher.
  TrainingRig::Arguments Student(const std::string& run, int iterations,
                                 bool mirror) const {
    return Train(
        run, iterations,
        {"--recipe", "pulse", "--teacher",
         JoinPath(rig_.Path("teacher"), "bundle"), "--set",
         "distillation.minibatch=32", "--set", "distillation.memory.rows=256",
         "--set",
         mirror ? "distillation.mirror=true" : "distillation.mirror=false"});
  }

  const TrainingRig rig_;
};

TEST_F(MirrorTest, TheStudentGoesOnWithTheSameBitsAndIsAnotherThanWithout) {
  rig_.MustRun("straight", Student("straight", 2, /*mirror=*/true));

  rig_.MustRun("half", Student("halves", 1, /*mirror=*/true));
  rig_.MustRun("rest", Student("halves", 2, /*mirror=*/true));

  EXPECT_EQ(rig_.FingerprintOf("halves"), rig_.FingerprintOf("straight"));
  rig_.MustRun("plain", Student("plain", 2, /*mirror=*/false));
  EXPECT_NE(rig_.TensorsOf("plain"), rig_.TensorsOf("straight"));
}

TEST(MirrorlessTest, ABodyWithoutSidesIsRefused) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);

  EXPECT_EQ(
      rig.Run("run",
              rig.Train("run", 1,
                        Taught(teacher, {"--set", "distillation.mirror=true"})))
          .code,
      kFailed);
  EXPECT_THAT(rig.Output("run"),
              AllOf(HasSubstr("recipe field distillation.mirror: "),
                    HasSubstr("mirror_joints: expected a pair")));
}

}  // namespace
}  // namespace sinew::tests
