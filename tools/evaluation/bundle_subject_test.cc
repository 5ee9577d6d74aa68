#include "tools/evaluation/bundle_subject.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A bundle and the library it was made for, on disk.
class BundleSubjects : public ::testing::Test {
 protected:
  void SetUp() override {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    bundle_ = JoinPath(toy.folder, "bundle");
    motions_ = JoinPath(toy.folder, "library");
    out_ = JoinPath(toy.folder, "eval.json");
    ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle_),
                IsOk());
  }

  // Replaces a word of the library's manifest.
  void TamperWithLibrary(const std::string& from, const std::string& to) {
    const std::string path = JoinPath(motions_, "manifest.json");
    const std::string text = *ReadFile(path);
    ASSERT_THAT(text, HasSubstr(from));
    ASSERT_THAT(
        WriteFileAtomically(path, absl::StrReplaceAll(text, {{from, to}})),
        IsOk());
  }

  std::string bundle_, motions_, out_;
};

TEST_F(BundleSubjects, AreEvaluatedIntoAFile) {
  const auto figures =
      EvaluateBundle(bundle_, motions_, out_,
                     {.starts = 2, .seconds = 1, .threads = 2}, StopToken());

  ASSERT_THAT(figures, IsOk());
  const auto file = nlohmann::json::parse(*ReadFile(out_));
  EXPECT_EQ(file["overall"]["starts"], 6);
  EXPECT_EQ(file["overall"]["e_g_mpjpe_mm"],
            figures->policy.overall.means.e_g_mpjpe_mm);
  EXPECT_EQ(file["bundle"]["path"], bundle_);
  EXPECT_EQ(file["bundle"]["manifest_sha256"].get<std::string>().size(), 64u);
}

TEST_F(BundleSubjects, RefuseClipsOfAnotherCharacter) {
  const auto bundle = bundle::ReadBundle(bundle_);
  ASSERT_THAT(bundle, IsOk());
  TamperWithLibrary(bundle->character->digest(), std::string(64, 'a'));

  EXPECT_THAT(LoadBundleSubject(bundle_, motions_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(motions_), HasSubstr(bundle_),
                             HasSubstr("character_sha256: expected"))));
}

TEST_F(BundleSubjects, RefuseClipsOfAnotherRate) {
  TamperWithLibrary("30", "60");

  EXPECT_THAT(LoadBundleSubject(bundle_, motions_),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("60")));
}

TEST_F(BundleSubjects, RefuseClipsWithOtherJoints) {
  TamperWithLibrary("\"hip_bl\"", "\"hip_xx\"");

  EXPECT_THAT(LoadBundleSubject(bundle_, motions_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("expected \"hip_bl\""),
                             HasSubstr("found \"hip_xx\""))));
}

TEST_F(BundleSubjects, NameWhatIsMissingAndWriteNothing) {
  EXPECT_THAT(EvaluateBundle(bundle_ + "x", motions_, out_, {}, StopToken()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(bundle_ + "x")));
  EXPECT_THAT(EvaluateBundle(bundle_, motions_ + "x", out_, {}, StopToken()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(motions_ + "x")));
  EXPECT_FALSE(FileExists(out_));
}

}  // namespace
}  // namespace sinew::evaluation
