#include "tools/training/run_sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/clip_uses.h"
#include "deploy/bundle/run_export.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

// A toy world with a bundle in it, and a run's folder.
struct Fixture {
  Fixture() {
    EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
                IsOk());
    EXPECT_THAT(MakeDirectories(run), IsOk());
  }

  std::optional<RunTeacher> Teacher(const std::string& sha256) const {
    std::optional<RunTeacher> teacher(std::in_place);
    v1::BundleSource& source =
        *teacher->sources.emplace_back().mutable_bundle();
    source.set_role("teacher");
    source.set_manifest_sha256(sha256);
    return teacher;
  }
  // Of a new run that begins with the bundle and learns from "expert".
  absl::StatusOr<std::vector<v1::RunInputs::Source>> Begin() const {
    return RunSources(run, /*resumption=*/std::nullopt,
                      {.init = bundle, .primitives = {}}, Teacher("expert"));
  }
  absl::StatusOr<std::vector<v1::RunInputs::Source>> Resume(
      const std::optional<RunTeacher>& teacher,
      const Resumption& resumption = {}) const {
    return RunSources(run, resumption, {}, teacher);
  }
  absl::Status Save(const std::vector<v1::RunInputs::Source>& sources) const {
    return bundle::SaveRunInputs(run,
                                 JoinPath(toy.folder, "character.textproto"),
                                 *toy.library, sources);
  }

  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  const std::string run = JoinPath(toy.folder, "run");
};

TEST(RunSources, AreTheBundlesThatARunBeginsWithThenItsTeacher) {
  const Fixture f;

  const auto sources = f.Begin();

  ASSERT_THAT(sources, IsOk());
  ASSERT_EQ(sources->size(), 2u);
  const auto read = bundle::ReadBundle(f.bundle);
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ((*sources)[0].bundle().role(), "init");
  EXPECT_EQ((*sources)[0].bundle().manifest_sha256(),
            read->manifest.manifest_sha256());
  EXPECT_EQ((*sources)[0].clips_size(),
            read->manifest.provenance().clips_size());
  EXPECT_EQ((*sources)[1].bundle().manifest_sha256(), "expert");
}

TEST(RunSources, StayAsTheyWereWhenARunIsResumed) {
  const Fixture f;
  const auto begun = f.Begin();
  ASSERT_THAT(begun, IsOk());
  ASSERT_THAT(f.Save(*begun), IsOk());

  const auto sources = f.Resume(f.Teacher("expert"));

  ASSERT_THAT(sources, IsOk());
  ASSERT_EQ(sources->size(), 2u);
  EXPECT_EQ((*sources)[0].bundle().role(), "init");
}

TEST(RunSources, RefuseAnotherTeacherThanBefore) {
  const Fixture f;
  ASSERT_THAT(f.Save({f.Teacher("expert")->sources[0]}), IsOk());

  EXPECT_THAT(f.Resume(f.Teacher("novice")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("--teacher"), HasSubstr("expert"),
                             HasSubstr("novice"))));
}

TEST(RunSources, NameSeveralTeachersWhoseOrderDoesNotMatter) {
  const Fixture f;
  std::optional<RunTeacher> teachers = f.Teacher("expert");
  teachers->sources.push_back(f.Teacher("novice")->sources[0]);
  const auto begun =
      RunSources(f.run, /*resumption=*/std::nullopt, {}, teachers);
  ASSERT_THAT(begun, IsOk());
  ASSERT_EQ(begun->size(), 2u);
  ASSERT_THAT(f.Save(*begun), IsOk());
  std::swap(teachers->sources[0], teachers->sources[1]);

  const auto resumed = f.Resume(teachers);

  ASSERT_THAT(resumed, IsOk());
  EXPECT_EQ((*resumed)[0].bundle().manifest_sha256(), "expert");
  EXPECT_THAT(f.Resume(f.Teacher("expert")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expert, novice")));
}

// "expert" labels a jump, "novice" a walk.
std::optional<RunTeacher> TwoTeachers(const Fixture& f) {
  std::optional<RunTeacher> teachers = f.Teacher("expert");
  teachers->sources.push_back(f.Teacher("novice")->sources[0]);
  teachers->sources[0].add_labelled_clips("jump");
  teachers->sources[1].add_labelled_clips("walk");
  teachers->by_evaluation = true;
  return teachers;
}

// The sources of a run of old, which do not say what they label.
std::vector<v1::RunInputs::Source> TwoTeachersOfOld(const Fixture& f) {
  std::vector<v1::RunInputs::Source> sources = TwoTeachers(f)->sources;
  for (v1::RunInputs::Source& source : sources) source.clear_labelled_clips();
  return sources;
}

TEST(RunSources, KeepWhichTeacherLabelsAClip) {
  const Fixture f;
  const std::optional<RunTeacher> teachers = TwoTeachers(f);
  ASSERT_THAT(f.Save(teachers->sources), IsOk());

  const auto resumed = f.Resume(teachers);

  ASSERT_THAT(resumed, IsOk());
  EXPECT_THAT((*resumed)[0].labelled_clips(), ElementsAre("jump"));
  EXPECT_THAT((*resumed)[1].labelled_clips(), ElementsAre("walk"));
  std::optional<RunTeacher> turned = TwoTeachers(f);
  turned->sources[0].set_labelled_clips(0, "walk");
  turned->sources[1].set_labelled_clips(0, "jump");
  EXPECT_THAT(f.Resume(turned),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("--teacher-eval"), HasSubstr("jump"),
                             HasSubstr("expert"), HasSubstr("novice"))));
}

// The library has a kick since, of which a third bundle knows more, and
// "novice" does best at nothing now.
TEST(RunSources, TakeOthersThatTeachALibraryThatHasChanged) {
  const Fixture f;
  std::optional<RunTeacher> teachers = TwoTeachers(f);
  ASSERT_THAT(f.Save(teachers->sources), IsOk());
  teachers->sources[1] = f.Teacher("kicker")->sources[0];
  teachers->sources[1].add_labelled_clips("kick");
  teachers->sources[0].add_labelled_clips("walk");

  const auto resumed = f.Resume(teachers, {.migrates = true});

  ASSERT_THAT(resumed, IsOk());
  ASSERT_EQ(resumed->size(), 3u);
  EXPECT_THAT((*resumed)[0].labelled_clips(), ElementsAre("jump", "walk"));
  EXPECT_EQ((*resumed)[1].bundle().manifest_sha256(), "novice");
  EXPECT_THAT((*resumed)[1].labelled_clips(), IsEmpty());
  EXPECT_EQ((*resumed)[2].bundle().manifest_sha256(), "kicker");
  // And so it goes on.
  ASSERT_THAT(f.Save(*resumed), IsOk());
  const auto again = f.Resume(teachers);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->size(), 3u);
  // By what they were trained on, the teachers stay.
  ASSERT_THAT(f.Save(TwoTeachers(f)->sources), IsOk());
  teachers->by_evaluation = false;
  EXPECT_THAT(f.Resume(teachers, {.migrates = true}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expert, novice")));
}

TEST(RunSources, OfOldWithoutLabelsRefuseEvaluations) {
  const Fixture f;
  ASSERT_THAT(f.Save(TwoTeachersOfOld(f)), IsOk());

  EXPECT_THAT(f.Resume(TwoTeachers(f)),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("--teacher-eval: expected none")));
  std::optional<RunTeacher> teachers = TwoTeachers(f);
  teachers->by_evaluation = false;
  EXPECT_THAT(f.Resume(teachers), IsOk());
  // Nor do they say that one of them labelled nothing.
  ASSERT_THAT(f.Save(TwoTeachersOfOld(f)), IsOk());
  teachers = TwoTeachers(f);
  teachers->by_evaluation = false;
  teachers->sources[1].clear_labelled_clips();
  EXPECT_THAT(f.Resume(teachers), IsOk());
}

TEST(RunSources, ComeWithACompactStateIntoAFolderThatHasNone) {
  const Fixture f;
  const auto begun = f.Begin();
  ASSERT_THAT(begun, IsOk());

  const auto sources =
      f.Resume(f.Teacher("expert"), {.moved = *begun, .migrates = true});

  ASSERT_THAT(sources, IsOk());
  ASSERT_EQ(sources->size(), 2u);
  EXPECT_EQ((*sources)[0].bundle().role(), "init");
  EXPECT_EQ((*sources)[1].bundle().role(), "teacher");
  EXPECT_THAT(
      f.Resume(f.Teacher("novice"), {.moved = *begun, .migrates = true}),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("expert"), HasSubstr("novice"))));
}

v1::CurriculumTable Table(const std::vector<std::string>& drawn,
                          const std::string& left_out) {
  v1::CurriculumTable table;
  for (const std::string& name : drawn) table.add_clips()->set_name(name);
  v1::CurriculumTable::Clip& other = *table.add_clips();
  other.set_name(left_out);
  other.set_left_out(true);
  return table;
}

TEST(AddEarlierTraining, KnowsClipsThatAreLeftOutSince) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  LeaveOut({1, 2}, toy);
  const v1::Start& start = toy.recipe.task().start();
  const v1::MotionLibrary& library = toy.library->manifest();
  const v1::CurriculumTable before = Table({"turn", "sway"}, "tumble");
  std::vector<v1::RunInputs::Source> sources;

  AddEarlierTraining(before, start, library, &sources);

  ASSERT_EQ(sources.size(), 1u);
  EXPECT_FALSE(sources[0].has_bundle());
  EXPECT_THAT(sources[0].clips(),
              ElementsAre("sway: made for tests (Apache-2.0)"));
  EXPECT_THAT(bundle::ClipUsesOfRun(start, library, sources),
              ElementsAre(Pair("sway", v1::CLIP_USE_SOURCE_TRAINED_ON),
                          Pair("tumble", v1::CLIP_USE_LEFT_OUT),
                          Pair("turn", v1::CLIP_USE_TRAINED_ON)));
  // It was killed before it saved a state with the new library.
  AddEarlierTraining(before, start, library, &sources);
  EXPECT_EQ(sources.size(), 1u);
}

TEST(AddEarlierTraining, AddsNothingWhereTheLibraryIsTheSame) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  LeaveOut({2}, toy);
  v1::Start start = toy.recipe.task().start();
  std::vector<v1::RunInputs::Source> sources;

  AddEarlierTraining(Table({"turn", "sway"}, "tumble"), start,
                     toy.library->manifest(), &sources);
  // Nor were starts ever drawn from what only_clips does not name.
  start.add_only_clips("turn");
  AddEarlierTraining(Table({"turn", "sway"}, "tumble"), start,
                     toy.library->manifest(), &sources);

  EXPECT_TRUE(sources.empty());
}

}  // namespace
}  // namespace sinew::tools
