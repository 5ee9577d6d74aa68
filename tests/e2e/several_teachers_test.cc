// Students of several teachers, by the real program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tests/testing/teacher_rig.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(SeveralTeachersTest, LearnsFromOneTeacherPerClip) {
  const TrainingRig rig;
  const auto only = [](const std::string& clips) {
    return TrainingRig::Arguments{"--set", "task.start.only_clips=" + clips};
  };
  const std::string turns = MakeTeacher(rig, "turns", only("[turn]"));
  const std::string others = MakeTeacher(rig, "others", only("[sway,tumble]"));

  rig.MustRun("run", rig.Train("run", 3, Taught(turns, {others})));

  const v1::BundleProvenance found = ProvenanceOf(rig, "run");
  ASSERT_EQ(found.sources_size(), 2);
  EXPECT_NE(found.sources(0).manifest_sha256(),
            found.sources(1).manifest_sha256());
  // Who labels what does not depend on the order, nor on where it is, and
  // matters.
  const Served served(rig, "served", others);
  rig.MustRun("swapped",
              rig.Train("swapped", 3, Taught(served.address, {turns})));
  EXPECT_EQ(rig.FingerprintOf("swapped"), rig.FingerprintOf("run"));
  rig.MustRun("one", rig.Train("one", 3, Taught(others)));
  EXPECT_NE(rig.TensorsOf("one"), rig.TensorsOf("run"));
  EXPECT_FALSE(
      rig.Run("alone", rig.Train("alone", 1, Taught(turns, {turns}))).ok());
  EXPECT_THAT(rig.Output("alone"), HasSubstr("expected several bundles"));
}

// What `sinew eval` says of a bundle, edited: it wins one clip and no other.
std::string EvaluationOf(const TrainingRig& rig, const std::string& name,
                         const std::string& bundle, const std::string& wins) {
  const std::string file = rig.Path(name + ".json");
  rig.MustRun(name + "_eval",
              {"eval", "--bundle", bundle, "--motions", rig.ToyFile("library"),
               "--starts", "1", "--seconds", "0.2", "--out", file});
  nlohmann::json json = nlohmann::json::parse(ReadFile(file).value());
  for (nlohmann::json& clip : json["clips"]) {
    clip["succeeded_starts"] = clip["name"] == wins ? 1 : 0;
  }
  EXPECT_THAT(WriteFileAtomically(file, json.dump()), IsOk());
  return file;
}

TEST(SeveralTeachersTest, LearnsFromTheBestByEvaluations) {
  const TrainingRig rig;
  const std::string one = MakeTeacher(rig, "one");
  const std::string two = MakeTeacher(rig, "two", {"--seed", "4"});
  const std::string turns = EvaluationOf(rig, "turns", one, "turn");
  const std::string sways = EvaluationOf(rig, "sways", two, "sway");
  const auto taught = [&](const std::string& first, const std::string& second) {
    return Taught(one, {two, "--teacher-eval", first, second});
  };
  // Both know all clips, and equally many.
  EXPECT_EQ(rig.Run("tie", rig.Train("tie", 1, Taught(one, {two}))).code,
            kMisused);
  EXPECT_THAT(rig.Output("tie"), HasSubstr("--teacher-eval"));

  rig.MustRun("straight", rig.Train("straight", 3, taught(turns, sways)));
  rig.MustRun("begin", rig.Train("run", 1, taught(sways, turns)));
  rig.MustRun("rest", rig.Train("run", 3, taught(turns, sways)));

  EXPECT_EQ(rig.FingerprintOf("run"), rig.FingerprintOf("straight"));
  EXPECT_EQ(ProvenanceOf(rig, "run").sources_size(), 2);
  EXPECT_THAT(rig.Output("begin"), HasSubstr("clips=1\n"));
  // The other way round it is another student, which no run becomes midway.
  const std::string sways_too = EvaluationOf(rig, "sways_too", one, "sway");
  const std::string turns_too = EvaluationOf(rig, "turns_too", two, "turn");
  EXPECT_FALSE(
      rig.Run("other", rig.Train("run", 4, taught(sways_too, turns_too))).ok());
  EXPECT_THAT(rig.Output("other"),
              AllOf(HasSubstr("--teacher-eval"), HasSubstr("clip sway")));
  rig.MustRun("swapped", rig.Train("swapped", 3, taught(sways_too, turns_too)));
  EXPECT_NE(rig.TensorsOf("swapped"), rig.TensorsOf("straight"));
}

}  // namespace
}  // namespace sinew::tests
