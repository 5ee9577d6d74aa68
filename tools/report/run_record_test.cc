#include "tools/report/run_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(Runs, AreReadWhateverIsDamaged) {
  const std::string folder = TestPath("run");
  testing::WriteRun(folder);
  ASSERT_THAT(AppendToFile(JoinPath(folder, "metrics.jsonl"), "{\"iter"),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "eval.json"), "[1"), IsOk());

  const auto run = ReadRun(folder);

  ASSERT_THAT(run, IsOk());
  EXPECT_THAT(run->rows, SizeIs(20));
  EXPECT_TRUE(run->evaluation.is_null());
  EXPECT_THAT(run->notes,
              ElementsAre(HasSubstr("1 lines are no JSON objects (first: line "
                                    "21)"),
                          HasSubstr("eval.json: expected a JSON object"),
                          HasSubstr("no bundle")));
}

// A run with an eval.json of the bundle with this digest.
std::string EvaluatedRun(const std::string& digest) {
  const std::string folder = TestPath("run");
  testing::WriteRun(folder);
  EXPECT_THAT(
      WriteFileAtomically(
          JoinPath(folder, "eval.json"),
          absl::StrCat(R"({"overall": {}, "bundle": {"path": "elsewhere", )",
                       R"("manifest_sha256": ")", digest,
                       R"("}, "library": {"path": "clips"}})")),
      IsOk());
  return folder;
}

void WriteManifest(const std::string& folder, const std::string& bundle,
                   const std::string& digest) {
  const std::string path = JoinPath(folder, bundle);
  ASSERT_THAT(MakeDirectories(path), IsOk());
  ASSERT_THAT(WriteFileAtomically(
                  JoinPath(path, "manifest.json"),
                  absl::StrCat(R"({"manifest_sha256": ")", digest, R"("})")),
              IsOk());
}

TEST(Runs, HaveTheEvaluationOfABundleThatTheyHave) {
  const std::string folder = EvaluatedRun("b");
  WriteManifest(folder, "bundle", "a");
  WriteManifest(folder, "bundle_best", "b");

  const auto run = ReadRun(folder);

  ASSERT_THAT(run, IsOk());
  EXPECT_TRUE(run->evaluation.is_object());
  EXPECT_EQ(run->bundle, JoinPath(folder, "bundle_best"));
  EXPECT_EQ(run->evaluated_motions, "clips");
  EXPECT_THAT(run->notes, ElementsAre());
}

TEST(Runs, LeaveOutTheEvaluationOfAnEarlierBundle) {
  const std::string folder = EvaluatedRun("before");
  WriteManifest(folder, "bundle", "a");
  WriteManifest(folder, "bundle_best", "b");

  const auto run = ReadRun(folder);

  ASSERT_THAT(run, IsOk());
  EXPECT_TRUE(run->evaluation.is_null());
  EXPECT_EQ(run->bundle, JoinPath(folder, "bundle"));
  EXPECT_EQ(run->evaluated_motions, "clips");
  EXPECT_THAT(run->notes, ElementsAre(HasSubstr("found before: left out")));
}

TEST(Runs, AreRefusedWhereThereIsNone) {
  const std::string folder = TestPath("empty");
  ASSERT_THAT(MakeDirectories(folder), IsOk());

  EXPECT_THAT(ReadRun(folder), StatusIs(absl::StatusCode::kNotFound,
                                        HasSubstr("expected a run directory")));
}

}  // namespace
}  // namespace sinew::report
