#include "deploy/runtime/testing/run_program.h"

#include <cstdlib>
#include <utility>

#include "absl/time/time.h"
#include "common/files.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::runtime::testing {

using ::sinew::testing::IsOk;

std::string Runfile(const std::string& name) {
  return JoinPath(std::getenv("TEST_SRCDIR"), name);
}

Outcome RunProgram(std::vector<std::string> argv) {
  const std::string log = JoinPath(std::getenv("TEST_TMPDIR"), "output.txt");
  EXPECT_THAT(RemoveRecursively(log), IsOk());
  auto child =
      Subprocess::Start({.argv = std::move(argv),
                         .environment = {{"PYTHONPATH", Runfile("onnx_python")},
                                         {"PYTHONDONTWRITEBYTECODE", "1"}},
                         .output_file = log});
  EXPECT_THAT(child, IsOk());
  if (!child.ok()) return {};
  const auto status = (*child)->Wait(absl::Minutes(2));
  EXPECT_THAT(status, IsOk());
  if (!status.ok()) return {};
  return {.code = status->code, .output = *ReadFile(log)};
}

}  // namespace sinew::runtime::testing
