#include "tools/report/reproduce.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "proto/sinew/v1/motion.pb.h"
#include "tools/report/run_record.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// One whole clip of one second of each of two files.
v1::MotionLibrary Library() {
  v1::MotionLibrary library;
  library.set_character("humanoid");
  library.set_frames_per_second(30);
  for (const char* name : {"walk", "run"}) {
    v1::ClipInfo& clip = *library.add_clips();
    clip.set_name(name);
    clip.set_num_frames(31);
    clip.set_source_file(std::string(name) + ".bvh");
    clip.mutable_source()->set_duration_s(1);
  }
  return library;
}

void AddMirror(int of, v1::MotionLibrary& library) {
  v1::ClipInfo clip = library.clips(of);
  clip.set_mirror_of(clip.name());
  clip.set_name(clip.name() + "_mirror");
  *library.add_clips() = clip;
}

RunRecord Trained() {
  RunRecord run;
  run.directory = "runs/one";
  return run;
}

std::string First(const v1::MotionLibrary& library,
                  const RunRecord& run = Trained(),
                  const std::string& motions = "mine") {
  return ReproduceCommands(run, library, motions)[0];
}

TEST(Reproduce, ImportsIntoAFolderOfItsOwnAndGoesOnThere) {
  const Json commands = ReproduceCommands(Trained(), Library(), "mine");

  ASSERT_EQ(commands.size(), 4);
  EXPECT_EQ(commands[0],
            "./sinew motion import --character humanoid --out "
            "runs/again/library run.bvh walk.bvh");
  for (size_t i = 1; i < commands.size(); ++i) {
    EXPECT_THAT(commands[i].get<std::string>(),
                HasSubstr(" --motions runs/again/library"));
  }
  EXPECT_THAT(commands.dump(), Not(HasSubstr("mine")));
}

TEST(Reproduce, ImportsAtTheLibrarysRateAndWithItsMirrorImages) {
  v1::MotionLibrary library = Library();
  AddMirror(0, library);
  AddMirror(1, library);
  library.set_frames_per_second(60);
  for (v1::ClipInfo& clip : *library.mutable_clips()) clip.set_num_frames(61);

  EXPECT_THAT(First(library), HasSubstr("/library --rate 60 --mirror run.bvh "
                                        "walk.bvh"));
}

TEST(Reproduce, TakesTheLibraryAsItIsWhereNoImportMakesIt) {
  v1::MotionLibrary left_out = Library(), mirrored = Library(), cut = Library(),
                    blended = Library();
  left_out.mutable_clips(1)->set_left_out(true);
  AddMirror(1, mirrored);  // and not of the other
  cut.mutable_clips(0)->set_num_frames(20);
  blended.mutable_clips(0)->mutable_blend()->set_gap_s(0.5);

  for (const v1::MotionLibrary& library : {left_out, mirrored, cut, blended}) {
    EXPECT_THAT(First(library), HasSubstr("./sinew train"));
    EXPECT_THAT(First(library), HasSubstr("--motions mine --run"));
  }
}

TEST(Reproduce, NamesAnotherCharacterThanTheUsualOne) {
  RunRecord run = Trained();
  EXPECT_THAT(First({}, run), Not(HasSubstr("--character")));
  run.manifest = {{"character", "humanoid"}};
  EXPECT_THAT(First({}, run), Not(HasSubstr("--character")));

  run.manifest = {{"character", "g1"}};

  EXPECT_THAT(First({}, run), HasSubstr(" --character g1"));
}

TEST(Reproduce, AsksForTheBundlesThatTheRunBeganWith) {
  RunRecord run = Trained();
  run.manifest = {{"provenance",
                   {{"sources",
                     {{{"role", "init"}},
                      {{"role", "primitive"}},
                      {{"role", "primitive"}}}}}}};
  EXPECT_THAT(First({}, run),
              HasSubstr(" --init BUNDLE --primitives BUNDLE BUNDLE"));

  // A run without a bundle has its recipe.
  run.manifest = nullptr;
  run.config = "network { composer { primitives: 3 } }";
  EXPECT_THAT(First({}, run), HasSubstr(" --primitives BUNDLE BUNDLE BUNDLE"));
  EXPECT_THAT(First({}, run), Not(HasSubstr("--init")));
}

TEST(Reproduce, HasCommandsThatAShellTakes) {
  RunRecord run;
  run.directory = "runs/my run";
  run.rows = testing::Rows(10);
  const Json commands = ReproduceCommands(run, {}, "it's");

  EXPECT_EQ(commands[0],
            "./sinew train --recipe 'runs/my run/config.textproto' --motions "
            "'it'\\''s' --run runs/again --iterations 10");
}

TEST(Reproduce, AsksForTheTeacherOfAStudent) {
  RunRecord run;
  run.directory = "runs/student";
  EXPECT_EQ(First({}, run, ""),
            "./sinew train --recipe runs/student/config.textproto --motions "
            "LIBRARY --run runs/again");

  run.config = "distillation {}";

  EXPECT_EQ(First({}, run, ""),
            "./sinew train --recipe runs/student/config.textproto --motions "
            "LIBRARY --run runs/again --teacher BUNDLE");

  run.manifest = {
      {"provenance",
       {{"sources", {{{"role", "teacher"}}, {{"role", "teacher"}}}}}}};

  EXPECT_THAT(First({}, run), HasSubstr(" --teacher BUNDLE BUNDLE"));
}

}  // namespace
}  // namespace sinew::report
