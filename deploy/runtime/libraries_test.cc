// A robot needs neither libtorch nor gRPC: by the build's own account, and by
// the loader's.
#include <cstdlib>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Runfile(const std::string& name) {
  return absl::StrCat(std::getenv("TEST_SRCDIR"), "/sinew/deploy/runtime/",
                      name);
}

// What a program prints.
std::string OutputOf(const std::string& program, const std::string& argument) {
  const std::string output = JoinPath(std::getenv("TEST_TMPDIR"), "output.txt");
  EXPECT_THAT(RemoveRecursively(output), IsOk());
  auto child =
      Subprocess::Start({.argv = {program, argument}, .output_file = output});
  EXPECT_THAT(child, IsOk());
  const auto status = (*child)->Wait(absl::Minutes(1));
  EXPECT_TRUE(status.ok() && status->ok()) << program;
  return *ReadFile(output);
}

TEST(RuntimeLibrary, IsBuiltWithoutTorchAndGrpc) {
  const std::string dependencies = *ReadFile(Runfile("library_dependencies"));

  EXPECT_THAT(dependencies, AllOf(HasSubstr("//sim/world:observation"),
                                  HasSubstr("@mujoco//:mujoco")));
  EXPECT_THAT(dependencies,
              AllOf(Not(HasSubstr("@libtorch")), Not(HasSubstr(":grpc")),
                    Not(HasSubstr("//learner")), Not(HasSubstr("//actor"))));
}

TEST(RuntimeLibrary, LoadsNeitherTorchNorGrpc) {
  const std::string libraries = OutputOf("ldd", Runfile("libsinew_runtime.so"));

  EXPECT_THAT(libraries, HasSubstr("libmujoco"));
  EXPECT_THAT(libraries, AllOf(Not(HasSubstr("torch")), Not(HasSubstr("grpc")),
                               Not(HasSubstr("not found"))));
}

}  // namespace
}  // namespace sinew::runtime
