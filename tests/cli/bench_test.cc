// `sinew bench`, as short as it goes: every section of the result is there and
// its figures are positive numbers; of a recipe that distils, the section of
// its student. How large they are is for a quiet machine to say.
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/time/time.h"
#include "common/files.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;

std::string Scratch(const std::string& name) {
  return JoinPath(std::getenv("TEST_TMPDIR"), name);
}

nlohmann::json ShortBench(const std::string& recipe) {
  const std::string out = Scratch(recipe + ".json");
  const std::string log = Scratch(recipe + ".log");
  const auto child = Subprocess::Start(
      {.argv = {JoinPath(std::getenv("TEST_SRCDIR"), "sinew/tools/sinew/sinew"),
                "bench", "--out", out, "--recipe", recipe, "--rounds", "1",
                "--updates", "1"},
       .output_file = log});
  EXPECT_THAT(child, IsOk());
  if (!child.ok()) return {};
  const auto status = (*child)->Wait(absl::Minutes(4));
  EXPECT_THAT(status, IsOk());
  if (!status.ok()) return {};
  EXPECT_EQ(status->code, 0) << *ReadFile(log);
  const auto text = ReadFile(out);
  return text.ok() ? nlohmann::json::parse(*text) : nlohmann::json();
}

void ExpectStudentFigures(const nlohmann::json& result,
                          const std::string& recipe) {
  const nlohmann::json& section = result["distillation"];
  EXPECT_EQ(section["recipe"], recipe) << result.dump(2);
  EXPECT_GT(section["rows_per_s"].get<double>(), 0) << result.dump(2);
  if (section["bfloat16_ratio"].is_null()) {
    EXPECT_NE(section["bfloat16_reason"].get<std::string>(), "");
  } else {
    EXPECT_GT(section["bfloat16_ratio"].get<double>(), 0);
  }
}

TEST(Bench, MeasuresEverySectionOfARecipe) {
  const nlohmann::json result = ShortBench("track_clip");
  for (const char* path :
       {"/actor/ratio", "/actor/two_threads/ratio", "/actor/products_us",
        "/learner/gemm_ratio", "/learner/two_rank_ratio",
        "/distillation/rows_per_s", "/distillation/flops_per_s",
        "/transport/gb_per_s", "/teacher/throughput_ratio"}) {
    const nlohmann::json::json_pointer pointer(path);
    ASSERT_TRUE(result.contains(pointer)) << path << " in " << result.dump(2);
    EXPECT_GT(result.at(pointer).get<double>(), 0) << path;
  }
  // A difference of two times, which other load may make negative.
  EXPECT_TRUE(result["actor"]["other_us"].is_number()) << result.dump(2);
  ExpectStudentFigures(result, "pulse");
}

TEST(Bench, MeasuresTheStudentOfARecipeThatDistils) {
  const nlohmann::json result = ShortBench("distil_experts");

  EXPECT_GT(result["learner"]["gemm_ratio"].get<double>(), 0);
  ExpectStudentFigures(result, "distil_experts");
}

}  // namespace
}  // namespace sinew
