#include "sim/character/character_files.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::UnorderedElementsAre;

std::string FolderOfTest() {
  return JoinPath(
      ::testing::TempDir(),
      ::testing::UnitTest::GetInstance()->current_test_info()->name());
}

// Writes files below `folder`; returns the path of the character.
std::string Write(const std::map<std::string, std::string>& files,
                  const std::string& folder) {
  for (const auto& [name, content] : files) {
    const std::string path = JoinPath(folder, name);
    EXPECT_THAT(
        MakeDirectories(std::filesystem::path(path).parent_path().string()),
        IsOk());
    EXPECT_THAT(WriteFileAtomically(path, content), IsOk());
  }
  return JoinPath(folder, "character.textproto");
}

std::unique_ptr<Character> LoadOrDie(const std::string& name_or_path,
                                     const v1::Physics& physics = {}) {
  auto character = Character::Load(name_or_path, physics);
  EXPECT_THAT(character, IsOk());
  return *std::move(character);
}

constexpr char kText[] = R"(
format_version: 1 name: "pole" model_file: "models/pole.xml"
joints { name: "hinge" stiffness: 10 damping: 1 torque_limit: 5 }
feet { body: "base" }
head_body: "arm"
standing_root_height: 0.1
actuator_law { derivation: "none" }
provenance: "made for tests" licence: "Apache-2.0"
)";

constexpr char kTriangles[] = R"(
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
)";

// A pole whose base touches the floor with one mesh and wears another.
std::map<std::string, std::string> Pole(const std::string& extra = "") {
  return {{"character.textproto", kText},
          {"models/parts/solid.obj", kTriangles},
          {"models/parts/dress.obj", kTriangles},
          {"models/pole.xml", absl::StrCat(R"(<mujoco>
  <compiler meshdir="parts"/>
  <asset><mesh file="solid.obj"/><mesh name="cloth" file="dress.obj"/></asset>
  )",
                                           extra, R"(
  <worldbody>
    <body name="base" pos="0 0 0.1"><freejoint/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <geom type="mesh" mesh="solid"/>
      <geom type="mesh" mesh="cloth" contype="0" conaffinity="0" group="2"/>
      <body name="arm" pos="0 0 0.2"><joint name="hinge" type="hinge"/>
        <geom size="0.05" mass="1"/></body>
    </body>
  </worldbody>
</mujoco>)")}};
}

TEST(CharacterFiles, OfTheHumanoidAreTheFilesThemselves) {
  const auto files = CharacterFiles("humanoid");

  ASSERT_THAT(files, IsOk());
  EXPECT_THAT(*files, UnorderedElementsAre(Key("character.textproto"),
                                           Key("humanoid.xml")));
  EXPECT_EQ(LoadOrDie(Write(*files, FolderOfTest()))->digest(),
            LoadOrDie("humanoid")->digest());
}

TEST(CharacterFiles, OfTheG1NeedNoMeshes) {
  const auto files = CharacterFiles("g1");

  ASSERT_THAT(files, IsOk());
  EXPECT_EQ(files->size(), 2);
  for (const auto& [name, content] : *files) {
    EXPECT_FALSE(absl::EndsWithIgnoreCase(name, ".stl")) << name;
    EXPECT_LT(content.size(), 100'000) << name;
  }
  const std::string copy = Write(*files, FolderOfTest());
  EXPECT_EQ(LoadOrDie(copy)->digest(), LoadOrDie("g1")->digest());
}

TEST(CharacterFiles, AreTheSameBodyWithSelfCollisionToo) {
  v1::Physics physics;
  physics.set_self_collision(true);
  const auto files = CharacterFiles("g1");
  ASSERT_THAT(files, IsOk());

  const auto copy = LoadOrDie(Write(*files, FolderOfTest()), physics);
  const auto original = LoadOrDie("g1", physics);

  EXPECT_EQ(copy->digest(), original->digest());
  EXPECT_EQ(copy->model()->nexclude, original->model()->nexclude);
}

TEST(CharacterFiles, KeepMeshesThatTouchAndDropThoseThatAreSeen) {
  const std::string original = Write(Pole(), JoinPath(FolderOfTest(), "from"));

  const auto files = CharacterFiles(original);

  ASSERT_THAT(files, IsOk());
  EXPECT_THAT(*files, UnorderedElementsAre(Key("character.textproto"),
                                           Key("models/pole.xml"),
                                           Key("models/parts/solid.obj")));
  EXPECT_EQ(LoadOrDie(Write(*files, JoinPath(FolderOfTest(), "to")))->digest(),
            LoadOrDie(original)->digest());
}

TEST(CharacterFiles, OfAModelThatIncludesOthersAreAllFiles) {
  auto parts = Pole("<include file=\"more.xml\"/>");
  parts["models/more.xml"] = "<mujoco><option gravity=\"0 0 -9\"/></mujoco>";
  const std::string original = Write(parts, FolderOfTest());

  const auto files = CharacterFiles(original);

  ASSERT_THAT(files, IsOk());
  EXPECT_EQ(*files, parts);
}

TEST(CharacterFiles, MustLieInTheModelsFolder) {
  auto parts = Pole("<include file=\"../more.xml\"/>");
  parts["more.xml"] = "<mujoco><option gravity=\"0 0 -9\"/></mujoco>";
  const std::string original = Write(parts, FolderOfTest());

  EXPECT_THAT(CharacterFiles(original),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected files in its own folder")));
}

TEST(CharacterFiles, NameACharacterThatIsNotThere) {
  EXPECT_THAT(CharacterFiles("centaur"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("centaur")));
}

}  // namespace
}  // namespace sinew::character
