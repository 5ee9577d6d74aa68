#include "sim/character/character_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A folder of characters named by $SINEW_CHARACTERS while the object lives.
class CharacterFolder {
 public:
  explicit CharacterFolder(const std::string& name)
      : path_(JoinPath(::testing::TempDir(), name)) {
    setenv("SINEW_CHARACTERS", path_.c_str(), /*overwrite=*/1);
  }
  ~CharacterFolder() { unsetenv("SINEW_CHARACTERS"); }

  // Writes a file below the folder; its path.
  std::string Add(const std::string& folder, const std::string& file) const {
    const std::string parent = JoinPath(path_, folder);
    EXPECT_THAT(MakeDirectories(parent), IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(parent, file), "x"), IsOk());
    return JoinPath(parent, file);
  }

 private:
  std::string path_;
};

TEST(FindCharacter, FindsOursInTheRunfiles) {
  EXPECT_THAT(FindCharacter("humanoid"),
              IsOkAndHolds(HasSubstr(
                  "sim/character/models/humanoid/character.textproto")));
}

TEST(FindCharacter, PrefersTheFoldersOfTheEnvironment) {
  const CharacterFolder folder("characters");
  const std::string path = folder.Add("humanoid", "character.textproto");

  EXPECT_THAT(FindCharacter("humanoid"), IsOkAndHolds(path));
}

TEST(FindCharacter, TakesAPathAsItIs) {
  const CharacterFolder folder("paths");
  const std::string path = folder.Add("mine", "character.textproto");

  EXPECT_THAT(FindCharacter(path), IsOkAndHolds(path));
  EXPECT_THAT(FindCharacter("/no/such/character.textproto"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("/no/such/character.textproto")));
}

TEST(FindCharacter, SaysWhatItExpectsWhereAPathIsAFolders) {
  const CharacterFolder folder("folders");
  const std::string path = folder.Add("mine", "character.textproto");
  const std::string parent = path.substr(0, path.rfind('/'));

  for (const std::string& given : {parent, parent + "/"}) {
    EXPECT_THAT(FindCharacter(given),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("expected a name (as \"humanoid\") or "
                                         "a .textproto file"),
                               HasSubstr("found the folder " + parent))));
  }
}

TEST(FindCharacter, TakesAFileOfTheWorkingFolderAsItIs) {
  EXPECT_THAT(FindCharacter("no_such.textproto"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("found no file no_such.textproto")));
}

TEST(FindCharacter, SaysWhereItLooked) {
  const CharacterFolder folder("empty");

  EXPECT_THAT(FindCharacter("nobody"),
              StatusIs(absl::StatusCode::kNotFound,
                       AllOf(HasSubstr("\"nobody\""), HasSubstr("empty"),
                             HasSubstr("sim/character/models"))));
}

TEST(FindModelFile, LooksBesideTheCharacter) {
  const CharacterFolder folder("beside");
  const std::string character = folder.Add("a", "character.textproto");
  const std::string model = folder.Add("a", "a.xml");

  EXPECT_THAT(FindModelFile(character, "a.xml"), IsOkAndHolds(model));
  EXPECT_THAT(
      FindModelFile(character, "b.xml"),
      StatusIs(absl::StatusCode::kNotFound,
               AllOf(HasSubstr(character), HasSubstr("model_file b.xml"))));
}

TEST(FindModelFile, LooksForFetchedFilesInFoldersAndRunfiles) {
  const CharacterFolder folder("fetched");
  const std::string model = folder.Add("some_robot/xmls", "r.xml");

  EXPECT_THAT(
      FindModelFile("/c/character.textproto", "@some_robot//xmls/r.xml"),
      IsOkAndHolds(model));
  EXPECT_THAT(
      FindModelFile("/c/character.textproto",
                    "@mjlab_g1//mjlab/asset_zoo/robots/unitree_g1/xmls/g1.xml"),
      IsOk());
}

TEST(FindModelFile, LooksInTheFolderThatAVariableNames) {
  const CharacterFolder folder("named");
  const std::string model = folder.Add("robots", "h.xml");
  const std::string root = model.substr(0, model.find("/robots"));
  setenv("SOME_ROBOTS", root.c_str(), /*overwrite=*/1);

  EXPECT_THAT(
      FindModelFile("/c/character.textproto", "$SOME_ROBOTS/robots/h.xml"),
      IsOkAndHolds(model));

  unsetenv("SOME_ROBOTS");
  EXPECT_THAT(
      FindModelFile("/c/character.textproto", "$SOME_ROBOTS/robots/h.xml"),
      StatusIs(absl::StatusCode::kNotFound,
               AllOf(HasSubstr("/c/SOME_ROBOTS/robots/h.xml"),
                     HasSubstr("$SOME_ROBOTS, which is not set"))));
}

TEST(FindModelFile, PrefersTheCopyBesideTheCharacter) {
  const CharacterFolder folder("bundled");
  const std::string character = folder.Add("b", "character.textproto");
  const std::string model = folder.Add("b/SOME_ROBOTS", "h.xml");
  EXPECT_THAT(FindModelFile(character, "$SOME_ROBOTS/h.xml"),
              IsOkAndHolds(model));
}

}  // namespace
}  // namespace sinew::character
