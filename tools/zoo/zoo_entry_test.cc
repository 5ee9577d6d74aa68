#include "tools/zoo/zoo_entry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/state_store.h"
#include "learner/state/testing/make_state.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/compact_state.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kUnfit = absl::StatusCode::kFailedPrecondition;

constexpr char kChapters[] = R"(
## Trained on

## Training

## Metrics

| zero action | 0 |

## Limitations

## How to make it again

## How to load it
)";

// A folder as zoo/ has them, but for its card.
class ZooEntry : public ::testing::Test {
 protected:
  explicit ZooEntry(const v1::Recipe& recipe = world::testing::ToyRecipe())
      : toy_(world::testing::MakeToyWorld(recipe)) {
    folder_ = JoinPath(toy_.folder, "entry");
    Write(bundle::testing::ToyContent(toy_));
  }

  void Write(const bundle::BundleContent& content) {
    EXPECT_THAT(MakeDirectories(folder_), IsOk());
    EXPECT_THAT(bundle::WriteBundle(content, JoinPath(folder_, "bundle")),
                IsOk());
    const auto bundle = bundle::ReadBundle(JoinPath(folder_, "bundle"));
    ASSERT_THAT(bundle, IsOk());
    manifest_ = bundle->manifest;
    WriteFile("eval.json", Figures(digest(), "library"));
    WriteFile("recipe.textproto", PrintRecipe(toy_.recipe));
  }
  void WriteFile(const std::string& name, const std::string& text) const {
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder_, name), text), IsOk());
  }
  void Remove(const std::string& name) const {
    EXPECT_THAT(RemoveRecursively(JoinPath(folder_, name)), IsOk());
  }
  std::string Licences() const {
    std::string text;
    for (const std::string& licence : manifest_.provenance().data_licences()) {
      absl::StrAppend(&text, "- ", licence, "\n");
    }
    return text;
  }
  std::string Card() const {
    return absl::StrCat(digest(), "\n", Licences(), kChapters);
  }
  static std::string Figures(absl::string_view of, absl::string_view library) {
    return absl::StrCat(R"({"bundle": {"path": "bundle", "manifest_sha256": ")",
                        of, R"("}, "library": {"path": ")", library, R"("}})");
  }
  const std::string& digest() const { return manifest_.manifest_sha256(); }

  const world::testing::ToyWorld toy_;
  std::string folder_;
  v1::BundleManifest manifest_;
};

TEST_F(ZooEntry, IsABundleItsCardItsFiguresAndItsRecipe) {
  WriteFile("CARD.md", Card());
  EXPECT_THAT(CheckZooEntry(folder_), IsOk());

  v1::Recipe other = toy_.recipe;
  other.set_name("other");
  WriteFile("recipe.textproto", PrintRecipe(other));
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("recipe.textproto: name")));
  WriteFile("recipe.textproto", "seed: none");
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("recipe.textproto")));
  for (const char* file : {"recipe.textproto", "eval.json"}) {
    Remove(file);
    EXPECT_THAT(CheckZooEntry(folder_),
                StatusIs(absl::StatusCode::kNotFound, HasSubstr(file)));
  }
}

TEST_F(ZooEntry, NeedsACardOfThisBundle) {
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("CARD.md")));
  WriteFile("CARD.md", absl::StrCat(Licences(), kChapters));
  EXPECT_THAT(
      CheckZooEntry(folder_),
      StatusIs(kUnfit, AllOf(HasSubstr("CARD.md"), HasSubstr(digest()))));
}

TEST_F(ZooEntry, NeedsEveryChapterAndFigures) {
  for (const char* chapter :
       {"## Trained on", "## Training", "## Metrics", "## Limitations",
        "## How to make it again", "## How to load it"}) {
    WriteFile("CARD.md", absl::StrReplaceAll(
                             Card(), {{absl::StrCat(chapter, "\n"), "\n"}}));
    EXPECT_THAT(CheckZooEntry(folder_), StatusIs(kUnfit, HasSubstr(chapter)));
  }
  WriteFile("CARD.md", absl::StrReplaceAll(Card(), {{"| zero action", "|"}}));
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("expected figures")));
}

TEST_F(ZooEntry, NeedsEveryLicence) {
  WriteFile("CARD.md", absl::StrCat(digest(), kChapters));
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("expected the licence")));

  bundle::BundleContent content = bundle::testing::ToyContent(toy_);
  content.manifest.mutable_provenance()->add_data_licences("unknown");
  Write(content);
  WriteFile("CARD.md", Card());
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("found one that is unknown")));
}

TEST_F(ZooEntry, HasFiguresOfThisBundleWithoutPathsOfAMachine) {
  WriteFile("CARD.md", Card());
  for (const char* name : {"eval.json", "fallen.json"}) {
    for (const std::string& other :
         {Figures("ab", "library"), std::string("{")}) {
      WriteFile(name, other);
      EXPECT_THAT(CheckZooEntry(folder_),
                  StatusIs(kUnfit, AllOf(HasSubstr(name),
                                         HasSubstr("bundle.manifest_sha256"),
                                         HasSubstr(digest()))));
    }
    WriteFile(name, Figures(digest(), "/home/library"));
    EXPECT_THAT(
        CheckZooEntry(folder_),
        StatusIs(kUnfit, AllOf(HasSubstr(name), HasSubstr("library.path"),
                               HasSubstr("found /home/library"))));
    WriteFile(name, Figures(digest(), "library"));
    EXPECT_THAT(CheckZooEntry(folder_), IsOk());
  }
}

// A run's state as it is moved elsewhere, with a recipe of these bytes.
void WriteState(absl::string_view recipe, const std::string& folder) {
  const SystemClock clock;
  const std::string run = testing::TestPath("checkpoints");
  const auto store = checkpoint::OpenStore(run, checkpoint::StoreAccess::kWrite,
                                           rpc::Security(), clock);
  ASSERT_THAT(store, IsOk());
  v1::TaskAssets list;
  v1::Asset& asset = *list.add_assets();
  asset.set_role("recipe");
  asset.set_sha256(Sha256Hex(recipe));
  const std::string assets = list.SerializeAsString();
  learner::Trainer::State state = learner::MakeState(12);
  state.counters.set_assets_sha256(Sha256Hex(assets));
  ASSERT_THAT(learner::SaveState(**store, state, /*keep=*/2), IsOk());
  ASSERT_THAT((*store)->PutBlob(std::make_shared<const std::string>(assets)),
              IsOk());
  ASSERT_THAT(tools::WriteCompactState(**store, folder, clock, {}), IsOk());
}

TEST_F(ZooEntry, MayHaveAStateOfItsRecipe) {
  WriteFile("CARD.md", Card());
  const std::string state = JoinPath(folder_, "state");
  WriteState(PrintRecipe(toy_.recipe), state);
  EXPECT_THAT(CheckZooEntry(folder_), IsOk());

  v1::Recipe changed = toy_.recipe;
  changed.set_seed(changed.seed() + 1);
  WriteFile("recipe.textproto", PrintRecipe(changed));
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, AllOf(HasSubstr(state),
                                     HasSubstr("of the recipe beside it"))));

  Remove("state");
  ASSERT_THAT(MakeDirectories(state), IsOk());
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(state)));
}

class LatentZooEntry : public ZooEntry {
 protected:
  LatentZooEntry() : ZooEntry(bundle::testing::ToyLatentRecipe()) {
    Write(bundle::testing::ToyLatentContent(toy_));
    WriteFile("CARD.md", absl::StrCat(Card(), "\nIts prior alone, 10 s"));
  }
  void WriteSamples(absl::string_view of, absl::string_view motions) const {
    WriteFile(
        "samples.json",
        absl::StrCat(R"({"bundle": "bundle", "manifest_sha256": ")", of,
                     R"(", "library": {"motions": ")", motions, R"("}})"));
  }
};

TEST_F(LatentZooEntry, HasSamplesOfItsPrior) {
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("samples.json")));
  WriteSamples("ab", "library");
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("samples.json: manifest_sha256")));
  WriteSamples(digest(), "/home/library");
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("samples.json: library.motions")));
  WriteSamples(digest(), "library");
  EXPECT_THAT(CheckZooEntry(folder_), IsOk());
  WriteFile("CARD.md", Card());
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("what its prior does alone")));
}

TEST_F(ZooEntry, IsNotLargerThanABundleMayBe) {
  const std::string bundle = JoinPath(folder_, "bundle");
  const auto bytes = CheckBundleBytes(bundle);
  ASSERT_THAT(bytes, IsOk());
  EXPECT_GT(*bytes, 0);
  const std::string filler(kMostBundleBytes - *bytes + 1, 'x');
  ASSERT_THAT(WriteFileAtomically(JoinPath(bundle, "filler"), filler), IsOk());

  EXPECT_THAT(CheckBundleBytes(bundle),
              StatusIs(kUnfit, AllOf(HasSubstr("at most 8000000 bytes"),
                                     HasSubstr("found 8000001"))));
  EXPECT_THAT(FolderBytes(JoinPath(folder_, "nowhere")),
              StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace sinew::zoo
