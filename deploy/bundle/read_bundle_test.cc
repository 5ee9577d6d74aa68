// Bundles are refused when anything in them is not what it was.
#include <cmath>
#include <functional>
#include <string>

#include "absl/strings/str_replace.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_folder.h"
#include "gmock/gmock.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::AllOf;
using ::testing::AnyOf;
using testing::FilesOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Toy;
using testing::WriteToy;

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

TEST(ReadBundle, RefusesAFlippedBitInAnyFile) {
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

TEST(ReadBundle, RefusesAnyTruncatedFile) {
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

TEST(ReadBundle, NamesAnyFileThatIsMissing) {
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

TEST(ReadBundle, NamesAFolderThatIsNone) {
  EXPECT_THAT(ReadBundle("/nowhere/at/all"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("/nowhere/at/all: expected a bundle")));
}

TEST(ReadBundle, RefusesAFileOfAnotherBundle) {
  const std::string directory = WriteToy();
  const std::string other = TestPath("other");
  ASSERT_THAT(WriteBundle(testing::ToyContent(Toy(), /*gain=*/0.5), other),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(directory, kWeightsFile),
                                  *ReadFile(JoinPath(other, kWeightsFile))),
              IsOk());

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("weights.safetensors: expected SHA-256")));
}

TEST(ReadBundle, RefusesANewerVersionByNumber) {
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

TEST(ReadBundle, RefusesAnEditedManifest) {
  const std::string directory = WriteToy();
  const std::string path = JoinPath(directory, kManifestFile);
  const std::string edited = absl::StrReplaceAll(
      *ReadFile(path), {{"made for tests (Apache-2.0)", "mine, all mine"}});
  ASSERT_THAT(WriteFileAtomically(path, edited), IsOk());

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr(path), HasSubstr("altered"))));
}

TEST(ReadBundle, RefusesAManifestWhoseJointsStandInAnotherOrder) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_joints()->SwapElements(1, 2);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: joints[1].name: expected "
                                 "\"hip_br\", found \"hip_fr\"")));
}

TEST(ReadBundle, RefusesAManifestWithOtherGains) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_joints(3)->set_damping(11);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: joints[3].damping (hip_bl): "
                                 "expected 10, found 11")));
}

TEST(ReadBundle, ChecksActionScalesWhereTheManifestHasThem) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_joints(2)->set_action_scale(0.2);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("joints[2].action_scale (hip_fr): expected "
                                 "0.3, found 0.2")));
  // As in bundles of old versions.
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                for (v1::BundleJoint& joint : *manifest.mutable_joints()) {
                  joint.clear_action_scale();
                }
              }),
              IsOk());
}

TEST(ReadBundle, RefusesAManifestWithOtherWidths) {
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

TEST(ReadBundle, RefusesALayoutThatTheNetworkDoesNotHave) {
  EXPECT_THAT(
      ReadEdited([](v1::BundleManifest& manifest) {
        manifest.mutable_task()->mutable_observation()->add_frames_ahead(4);
        *manifest.mutable_observation() = manifest.task().observation();
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("observation_width: expected")));
}

TEST(ReadBundle, RefusesAnActionLawThatIsNotTheTasks) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_action()->set_scale(0.3);
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("manifest.json: action: expected")));
}

TEST(ReadBundle, RefusesOtherBodiesAndCharacters) {
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

TEST(ReadBundle, WantsAUseOfEveryClipOrOfNoneAsInOldBundles) {
  EXPECT_THAT(
      ReadEdited([](v1::BundleManifest& manifest) {
        manifest.mutable_provenance()->mutable_clip_uses()->RemoveLast();
      }),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("manifest.json: provenance.clip_uses: their "
                         "number: expected 3, found 2")));
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                manifest.mutable_provenance()->clear_clip_uses();
              }),
              IsOk());
}

TEST(ReadBundle, RefusesPathsThatLeaveTheFolder) {
  EXPECT_THAT(ReadEdited([](v1::BundleManifest& manifest) {
                (*manifest.mutable_files())["../secret"] = std::string(64, '0');
              }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("files: expected a path inside the bundle, "
                                 "found \"../secret\"")));
}

TEST(ReadBundle, RefusesWeightsThatAreNotFinite) {
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

TEST(ReadBundle, RefusesWeightsThatTheGraphDoesNotFit) {
  const std::string directory = WriteToy();
  TensorMap weights = testing::ToyContent(Toy()).weights;
  weights.erase("policy/mean/bias");

  Forge(directory, kWeightsFile, SerializeSafetensors(weights));

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("weights.safetensors"),
                             HasSubstr("policy/mean/bias"))));
}

TEST(ReadBundle, RefusesActionsThatAreHeldForSeveralSteps) {
  const std::string directory = WriteToy();
  v1::PolicyGraph all = testing::ToyContent(Toy()).graph;
  for (v1::Graph& graph : *all.mutable_graphs()) {
    for (v1::Tap& tap : *graph.mutable_taps()) {
      if (tap.executed()) tap.set_decision_period(5);
    }
  }
  std::string text;
  ASSERT_TRUE(google::protobuf::TextFormat::PrintToString(all, &text));

  Forge(directory, kGraphFile, text);

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("graph.textproto: graph policy: tap "
                                       "action: decision_period: expected 0"),
                             HasSubstr("found 5"))));
}

TEST(ReadBundle, RefusesACharacterWithAnotherBody) {
  const std::string directory = WriteToy();
  const std::string mjcf = *ReadFile(JoinPath(directory, "character/toy.xml"));

  Forge(directory, "character/toy.xml",
        absl::StrReplaceAll(mjcf, {{"mass=\"6\"", "mass=\"7\""}}));

  EXPECT_THAT(ReadBundle(directory),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("character_sha256: expected")));
}

}  // namespace
}  // namespace sinew::bundle
