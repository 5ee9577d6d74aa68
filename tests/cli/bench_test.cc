// `sinew bench` with the default recipe, as short as it goes: every section of
// the result is there and its figures are positive numbers. How large they are
// is for a quiet machine to say.
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

TEST(Bench, MeasuresEverySectionWithTheDefaultRecipe) {
  const std::string out = Scratch("bench.json");
  const std::string log = Scratch("log");
  const auto child = Subprocess::Start(
      {.argv = {JoinPath(std::getenv("TEST_SRCDIR"), "sinew/tools/sinew/sinew"),
                "bench", "--out", out, "--rounds", "1", "--updates", "1"},
       .output_file = log});
  ASSERT_THAT(child, IsOk());

  const auto status = (*child)->Wait(absl::Minutes(4));

  ASSERT_THAT(status, IsOk());
  ASSERT_EQ(status->code, 0) << *ReadFile(log);
  const auto result = nlohmann::json::parse(*ReadFile(out));
  for (const char* path : {"/actor/ratio", "/actor/two_threads/ratio",
                           "/actor/products_us", "/learner/gemm_ratio",
                           "/learner/two_rank_ratio", "/transport/gb_per_s"}) {
    const nlohmann::json::json_pointer pointer(path);
    ASSERT_TRUE(result.contains(pointer)) << path << " in " << result.dump(2);
    EXPECT_GT(result.at(pointer).get<double>(), 0) << path;
  }
  // A difference of two times, which other load may make negative.
  EXPECT_TRUE(result["actor"]["other_us"].is_number()) << result.dump(2);
}

}  // namespace
}  // namespace sinew
