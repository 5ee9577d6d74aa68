// Bundles are written whole, read back equal, and refused when anything in them
// is not what it was.
#include "deploy/bundle/bundle.h"

#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/config/text_proto.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const world::testing::ToyWorld& Toy() {
  static const auto* toy =
      new world::testing::ToyWorld(world::testing::MakeToyWorld());
  return *toy;
}

std::string FolderOfTest() {
  return JoinPath(
      ::testing::TempDir(),
      ::testing::UnitTest::GetInstance()->current_test_info()->name());
}

// A new toy bundle in a folder of the running test's own.
std::string WriteToy(const std::string& name = "toy") {
  const std::string directory = JoinPath(FolderOfTest(), name);
  EXPECT_THAT(RemoveRecursively(directory), IsOk());
  EXPECT_THAT(WriteBundle(testing::ToyContent(Toy()), directory), IsOk());
  return directory;
}

// Replaces a file's content and gives the manifest its digest, as somebody
// would who wants it to pass.
void Forge(const std::string& directory, const std::string& file,
           const std::string& content) {
  ASSERT_THAT(WriteFileAtomically(JoinPath(directory, file), content), IsOk());
  const std::string path = JoinPath(directory, kManifestFile);
  v1::BundleManifest manifest = *ParseManifest(*ReadFile(path), path);
  (*manifest.mutable_files())[file] = Sha256Hex(content);
  ASSERT_THAT(WriteFileAtomically(path, *PrintManifest(manifest)), IsOk());
}

// Edits the manifest and signs it again.
absl::Status ReadEdited(const std::function<void(v1::BundleManifest&)>& edit) {
  const std::string directory = WriteToy();
  const std::string path = JoinPath(directory, kManifestFile);
  v1::BundleManifest manifest = *ParseManifest(*ReadFile(path), path);
  edit(manifest);
  EXPECT_THAT(WriteFileAtomically(path, *PrintManifest(manifest)), IsOk());
  return ReadBundle(directory).status();
}

std::vector<std::string> FilesOf(const std::string& directory) {
  std::vector<std::string> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    files.push_back(entry.path().lexically_relative(directory).string());
  }
  return files;
}

TEST(Bundle, ReadsBackWhatWasWritten) {
  const BundleContent content = testing::ToyContent(Toy());

  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(bundle->graph, EqualsProto(content.graph));
  EXPECT_EQ(SerializeSafetensors(bundle->weights),
            SerializeSafetensors(content.weights));
  EXPECT_EQ(bundle->character->digest(), Toy().character->digest());
  EXPECT_THAT(bundle->manifest.graphs(), ElementsAre("policy"));
  EXPECT_EQ(bundle->manifest.joints(2).name(), "hip_fr");
  EXPECT_EQ(bundle->manifest.joints(2).stiffness(), 100);
  EXPECT_EQ(bundle->manifest.bodies(0), "trunk");
  EXPECT_EQ(bundle->manifest.control_hz(), 30);
  EXPECT_EQ(bundle->manifest.action_width(), 4);
  EXPECT_EQ(bundle->manifest.observation_width(), 33 + 35);
  EXPECT_THAT(bundle->manifest.provenance().clips(),
              ElementsAre("turn: made for tests (Apache-2.0)",
                          "sway: made for tests (Apache-2.0)",
                          "tumble: made for tests (Apache-2.0)"));
  EXPECT_THAT(bundle->manifest.provenance().data_licences(),
              ElementsAre("Apache-2.0"));
  EXPECT_EQ(bundle->manifest.provenance().library_sha256(),
            Toy().library->digest());
}

TEST(Bundle, GivesBackTheRecipeOfItsTask) {
  const auto bundle = ReadBundle(WriteToy());

  ASSERT_THAT(bundle, IsOk());
  const v1::Recipe recipe = TaskRecipe(bundle->manifest);
  EXPECT_THAT(recipe.task(), EqualsProto(Toy().recipe.task()));
  EXPECT_THAT(recipe.physics(), EqualsProto(Toy().recipe.physics()));
}

TEST(Bundle, SameContentGivesSameBytes) {
  const std::string a = WriteToy("a");
  const std::string b = WriteToy("b");

  for (const std::string& file : FilesOf(a)) {
    EXPECT_EQ(*ReadFile(JoinPath(a, file)), *ReadFile(JoinPath(b, file)))
        << file;
  }
}

TEST(Bundle, RefusesAFlippedBitInAnyFile) {
  const std::string directory = WriteToy();
  for (const std::string& file : FilesOf(directory)) {
    const std::string path = JoinPath(directory, file);
    const std::string whole = *ReadFile(path);
    for (const size_t at : {whole.size() / 3, whole.size() - 2}) {
      std::string flipped = whole;
      flipped[at] ^= 1;
      ASSERT_THAT(WriteFileAtomically(path, flipped), IsOk());

      EXPECT_THAT(
          ReadBundle(directory),
          AllOf(Not(IsOk()),
                AnyOf(StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)),
                      StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr(path)))))
          << file << " at " << at;
    }
    ASSERT_THAT(WriteFileAtomically(path, whole), IsOk());
  }
  EXPECT_THAT(ReadBundle(directory), IsOk());
}

TEST(Bundle, RefusesAnyTruncatedFile) {
  const std::string directory = WriteToy();
  for (const std::string& file : FilesOf(directory)) {
    const std::string path = JoinPath(directory, file);
    const std::string whole = *ReadFile(path);
    for (const size_t size : {size_t{0}, whole.size() / 2, whole.size() - 1}) {
      ASSERT_THAT(WriteFileAtomically(path, whole.substr(0, size)), IsOk());

      const absl::Status status = ReadBundle(directory).status();

      EXPECT_TRUE(absl::IsDataLoss(status) || absl::IsInvalidArgument(status))
          << file << " " << status;
      EXPECT_THAT(std::string(status.message()), HasSubstr(path)) << size;
    }
    ASSERT_THAT(WriteFileAtomically(path, whole), IsOk());
  }
}

TEST(Bundle, NamesAnyFileThatIsMissing) {
  const std::string directory = WriteToy();
  for (const std::string& file : FilesOf(directory)) {
    const std::string path = JoinPath(directory, file);
    const std::string whole = *ReadFile(path);
    ASSERT_THAT(RemoveRecursively(path), IsOk());

    EXPECT_THAT(ReadBundle(directory),
                StatusIs(absl::StatusCode::kNotFound, HasSubstr(file)));

    ASSERT_THAT(WriteFileAtomically(path, whole), IsOk());
  }
}

TEST(Bundle, NamesAFolderThatIsNone) {
  EXPECT_THAT(ReadBundle("/nowhere/at/all"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("/nowhere/at/all: expected a bundle")));
}

TEST(Bundle, RefusesAFileOfAnotherBundle) {
  const std::string directory = WriteToy();
  const std::string other = JoinPath(FolderOfTest(), "other");
  ASSERT_THAT(WriteBundle(testing::ToyContent(Toy(), /*gain=*/0.5), other),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(directory, kWeightsFile),
                                  *ReadFile(JoinPath(other, kWeightsFile))),
              IsOk());

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("weights.safetensors: expected SHA-256")));
}

TEST(Bundle, RefusesANewerVersionByNumber) {
  const std::string directory = WriteToy();
  const std::string path = JoinPath(directory, kManifestFile);
  const std::string newer = absl::StrReplaceAll(
      *ReadFile(path),
      {{"\"format_version\": 1,", "\"format_version\": 2, \"tomorrow\": 3,"}});
  ASSERT_THAT(WriteFileAtomically(path, newer), IsOk());

  EXPECT_THAT(
      ReadBundle(directory),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr(path), HasSubstr("format_version: expected 1, "
                                                "found 2: written by a newer "
                                                "version"))));
}

TEST(Bundle, RefusesAnEditedManifest) {
  const std::string directory = WriteToy();
  const std::string path = JoinPath(directory, kManifestFile);
  const std::string edited = absl::StrReplaceAll(
      *ReadFile(path), {{"made for tests (Apache-2.0)", "mine, all mine"}});
  ASSERT_THAT(WriteFileAtomically(path, edited), IsOk());

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr(path), HasSubstr("altered"))));
}

TEST(Bundle, RefusesAManifestWhoseJointsStandInAnotherOrder) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_joints()->SwapElements(1, 2);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: joints[1].name: expected "
                                 "\"hip_br\", found \"hip_fr\"")));
}

TEST(Bundle, RefusesAManifestWithOtherGains) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_joints(3)->set_damping(11);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: joints[3].damping (hip_bl): "
                                 "expected 10, found 11")));
}

TEST(Bundle, RefusesAManifestWithOtherWidths) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.set_observation_width(67);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("observation_width: expected 68, found 67")));
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.set_action_width(3);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("action_width: expected 4, found 3")));
}

TEST(Bundle, RefusesALayoutThatTheNetworkDoesNotHave) {
  EXPECT_THAT(
      ReadEdited([](v1::BundleManifest& manifest) {
        manifest.mutable_task()->mutable_observation()->add_frames_ahead(4);
        *manifest.mutable_observation() = manifest.task().observation();
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("observation_width: expected")));
}

TEST(Bundle, RefusesAnActionLawThatIsNotTheTasks) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_action()->set_scale(0.3);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: action: expected")));
}

TEST(Bundle, RefusesOtherBodiesAndCharacters) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_bodies()->RemoveLast();
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: bodies: expected")));
  EXPECT_THAT(
      ReadEdited(
          [](v1::BundleManifest& manifest) { manifest.set_character("tyo"); }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("character: expected \"toy\", found \"tyo\"")));
}

TEST(Bundle, RefusesPathsThatLeaveTheFolder) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                (*manifest.mutable_files())["../secret"] = std::string(64, '0');
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("files: expected a path inside the bundle, "
                                 "found \"../secret\"")));
}

TEST(Bundle, RefusesWeightsThatAreNotFinite) {
  const std::string directory = WriteToy();
  TensorMap weights = testing::ToyContent(Toy()).weights;
  weights.at("policy/mean/bias").mutable_float32()[1] = NAN;

  Forge(directory, kWeightsFile, SerializeSafetensors(weights));

  EXPECT_THAT(
      ReadBundle(directory),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("weights.safetensors"),
                     HasSubstr("policy/mean/bias"), HasSubstr("not finite"))));
}

TEST(Bundle, RefusesWeightsThatTheGraphDoesNotFit) {
  const std::string directory = WriteToy();
  TensorMap weights = testing::ToyContent(Toy()).weights;
  weights.erase("policy/mean/bias");

  Forge(directory, kWeightsFile, SerializeSafetensors(weights));

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("weights.safetensors"),
                             HasSubstr("policy/mean/bias"))));
}

TEST(Bundle, RefusesACharacterWithAnotherBody) {
  const std::string directory = WriteToy();
  const std::string mjcf = *ReadFile(JoinPath(directory, "character/toy.xml"));

  Forge(directory, "character/toy.xml",
        absl::StrReplaceAll(mjcf, {{"mass=\"6\"", "mass=\"7\""}}));

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("character_sha256: expected")));
}

TEST(WriteBundle, ReplacesTheOldOneAndLeavesNothingElse) {
  const std::string directory = WriteToy();
  const BundleContent content = testing::ToyContent(Toy(), /*gain=*/0.5);

  EXPECT_THAT(WriteBundle(content, directory), IsOk());

  const auto bundle = ReadBundle(directory);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(SerializeSafetensors(bundle->weights),
            SerializeSafetensors(content.weights));
  EXPECT_THAT(*ListDirectory(FolderOfTest()), ElementsAre("toy"));
}

TEST(WriteBundle, RefusesContentThatReadBundleWould) {
  const std::string directory = WriteToy();
  const std::string before = *ReadFile(JoinPath(directory, kManifestFile));
  BundleContent content = testing::ToyContent(Toy());
  content.manifest.mutable_joints(0)->set_name("tail");

  EXPECT_THAT(WriteBundle(content, directory),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("tail")));

  EXPECT_EQ(*ReadFile(JoinPath(directory, kManifestFile)), before);
  EXPECT_THAT(*ListDirectory(FolderOfTest()), ElementsAre("toy"));
}

TEST(WriteBundle, KeepsTheOldOneWhenTheDiskIsFull) {
  const std::string directory = WriteToy();
  const std::string before = *ReadFile(JoinPath(directory, kManifestFile));
  const BundleContent content = testing::ToyContent(Toy(), /*gain=*/0.5);
  // No file may grow beyond 8 KiB: the nearest to a full disk without a mount.
  const sighandler_t handler = signal(SIGXFSZ, SIG_IGN);
  rlimit limit;
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small = {8192, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);

  const absl::Status status = WriteBundle(content, directory);

  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, handler);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(*ReadFile(JoinPath(directory, kManifestFile)), before);
  EXPECT_THAT(ReadBundle(directory), IsOk());
  EXPECT_THAT(*ListDirectory(FolderOfTest()), ElementsAre("toy"));
}

int64_t SizeOf(const std::string& directory) {
  int64_t size = 0;
  for (const std::string& file : FilesOf(directory)) {
    size += *FileSize(JoinPath(directory, file));
  }
  return size;
}

TEST(WriteBundle, OurCharactersAreSmallAndStandAlone) {
  for (const std::string name : {"humanoid", "g1"}) {
    const BundleContent content =
        testing::CharacterContent(name, WithDefaults(v1::Recipe()));
    const std::string directory = JoinPath(FolderOfTest(), name);

    ASSERT_THAT(WriteBundle(content, directory), IsOk());

    EXPECT_LT(SizeOf(directory), 8 << 20) << name;
    for (const std::string& file : FilesOf(directory)) {
      EXPECT_FALSE(absl::EndsWithIgnoreCase(file, ".stl")) << file;
    }
    ::testing::Test::RecordProperty(name + "_bytes",
                                    static_cast<int>(SizeOf(directory)));
  }
}

}  // namespace
}  // namespace sinew::bundle
