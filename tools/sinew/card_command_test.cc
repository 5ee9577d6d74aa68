#include "tools/sinew/card_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sinew/testing/run_command.h"
#include "tools/zoo/zoo_entry.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::RunCommand;

absl::Status MakeCard(const std::string& bundle, const std::string& motions,
                      const std::string& out) {
  return RunCommand(AddCardCommand,
                    absl::StrCat("card --machine lab --bundle ", bundle,
                                 " --motions ", motions, " --out ", out));
}

TEST(CardCommand, WritesTheCardOfABundleThatIsSmallEnough) {
  const auto toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  const std::string out = JoinPath(toy.folder, "CARD.md");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());

  ASSERT_THAT(MakeCard(bundle, toy.library_folder, out), IsOk());
  const auto card = ReadFile(out);
  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("| machine | lab |"));

  ASSERT_THAT(RemoveRecursively(out), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(bundle, "filler"),
                                  std::string(zoo::kMostBundleBytes, 'x')),
              IsOk());
  EXPECT_THAT(MakeCard(bundle, toy.library_folder, out),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("at most 8000000 bytes")));
  EXPECT_FALSE(FileExists(out));
}

}  // namespace
}  // namespace sinew::tools
