#include "tools/sinew/sample_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunCommand;
using Json = nlohmann::json;

struct Toy {
  world::testing::ToyWorld world =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  std::string bundle = bundle::testing::WriteToyLatent(world);
  std::string out = JoinPath(world.folder, "samples.json");

  std::string Arguments(const std::string& more) const {
    return "--bundle " + bundle + " --out " + out + " " + more;
  }
  std::string WithMotions(const std::string& more) const {
    return Arguments("--motions " + world.library_folder + " " + more);
  }
  Json Read() const { return Json::parse(*ReadFile(out)); }
};

absl::Status Sample(const std::string& arguments,
                    std::string* output = nullptr) {
  std::string printed;
  return RunCommand(AddSampleCommand, "sample " + arguments, /*stop=*/{},
                    output != nullptr ? output : &printed);
}

TEST(Sample, MeasuresEachScaleOfTheNoiseBesideNone) {
  const Toy toy;
  std::string output;

  ASSERT_THAT(Sample(toy.WithMotions("--seconds 0.5 --count 8 --noise 2 "
                                     "--noise 0.5 --student --threads 2"),
                     &output),
              IsOk());

  EXPECT_THAT(output, AllOf(HasSubstr("zero action"), HasSubstr("zero noise"),
                            HasSubstr("noise 0.5"), HasSubstr("noise 2"),
                            HasSubstr(toy.out)));
  const Json json = toy.Read();
  EXPECT_EQ(json["start"], "clip");
  EXPECT_EQ(json["seconds"], 0.5);
  EXPECT_EQ(json["library"]["transitions"], 58);
  EXPECT_EQ(json["library"]["threshold"], 0.5);
  EXPECT_GT(json["student"]["generated"], 0);
  EXPECT_GT(json["student"]["latent_mean"]["step"], 0);
  EXPECT_THAT(json["definitions"]["student"].get<std::string>(),
              AllOf(HasSubstr("in the world of evaluations: not randomised"),
                    HasSubstr("samples move in the same physics")));
  ASSERT_EQ(json["ways"].size(), 4);
  const Json& action = json["ways"][0];
  EXPECT_EQ(action["name"], "zero action");
  EXPECT_TRUE(action["noise"].is_null());
  EXPECT_TRUE(action["latent"].is_null());
  EXPECT_EQ(action["samples"], 2);  // one of each start
  const Json& noisy = json["ways"][3];
  EXPECT_EQ(noisy["name"], "noise 2");
  EXPECT_EQ(noisy["samples"], 8);
  EXPECT_EQ(noisy["starts"], 2);
  EXPECT_EQ(noisy["rows"].size(), 8);
  EXPECT_EQ(noisy["began_upright"], 8);
  EXPECT_TRUE(noisy["got_up_share"].is_null());
  EXPECT_TRUE(noisy["stuck_share"].is_null());
  EXPECT_EQ(noisy["diversity"]["pairs"], 12);  // two starts, 6 pairs each
  EXPECT_GT(noisy["diversity"]["over_time_m"], 0);
  EXPECT_EQ(noisy["transitions"]["generated"], 8 * 14);
  EXPECT_GT(noisy["transitions"]["distance"], 0);
  EXPECT_GT(noisy["latent"]["step"], json["ways"][1]["latent"]["step"]);
}

TEST(Sample, ThinsWhatTheStudentDoesAsItThinsTheLibrary) {
  const Toy toy;
  const std::string flags = "--seconds 0.5 --count 2 --student";
  ASSERT_THAT(Sample(toy.WithMotions(flags)), IsOk());
  const Json all = toy.Read()["student"];
  ASSERT_GT(all["generated_all"], 5);
  EXPECT_EQ(all["generated"], all["generated_all"]);

  ASSERT_THAT(Sample(toy.WithMotions(flags + " --transitions 5")), IsOk());

  const Json some = toy.Read()["student"];
  EXPECT_EQ(some["generated"], 5);
  EXPECT_EQ(some["generated_all"], all["generated_all"]);
}

TEST(Sample, WritesTheSameFileForAnyNumberOfThreads) {
  const Toy toy;
  const std::string flags = "--seconds 0.3 --count 20 ";

  ASSERT_THAT(Sample(toy.WithMotions(flags + "--threads 1")), IsOk());
  const std::string one = *ReadFile(toy.out);
  ASSERT_THAT(Sample(toy.WithMotions(flags + "--threads 3")), IsOk());

  EXPECT_EQ(*ReadFile(toy.out), one);
}

TEST(Sample, BeginsOnTheFloorWithoutALibrary) {
  const Toy toy;

  ASSERT_THAT(Sample(toy.Arguments("--seconds 0.2 --count 2")), IsOk());

  const Json json = toy.Read();
  EXPECT_EQ(json["start"], "fallen");
  EXPECT_FALSE(json.contains("library"));
  EXPECT_FALSE(json["ways"][2].contains("transitions"));
}

TEST(Sample, PrintsTheTableAloneWithoutAFileToWrite) {
  const Toy toy;
  const std::string flags = "--seconds 0.2 --count 2 --noise 1 ";
  std::string with, without;
  ASSERT_THAT(Sample(toy.Arguments(flags), &with), IsOk());
  ASSERT_THAT(RemoveRecursively(toy.out), IsOk());
  const auto before = ListDirectory(toy.world.folder);
  ASSERT_THAT(before, IsOk());

  EXPECT_THAT(Sample("--bundle " + toy.bundle + " " + flags, &without), IsOk());

  EXPECT_THAT(without, AllOf(HasSubstr("zero action"), HasSubstr("noise 1")));
  EXPECT_EQ(with, without + toy.out + "\n");
  EXPECT_THAT(ListDirectory(toy.world.folder), IsOkAndHolds(*before));
}

TEST(Sample, WritesAPageWithoutTheFile) {
  const Toy toy;
  const std::string page = JoinPath(toy.world.folder, "samples.html");

  ASSERT_THAT(Sample("--bundle " + toy.bundle +
                     " --seconds 0.2 --count 2 --page " + page),
              IsOk());

  EXPECT_TRUE(FileExists(page));
  EXPECT_FALSE(FileExists(toy.out));
}

TEST(Sample, WritesPathsThatAreNoText) {
  Toy toy;
  std::filesystem::rename(toy.bundle, toy.bundle + "\xff");
  toy.bundle += "\xff";

  ASSERT_THAT(Sample(toy.Arguments("--seconds 0.2 --count 2")), IsOk());

  EXPECT_FALSE(toy.Read()["ways"].empty());
}

TEST(Sample, BeginsWhereItIsTold) {
  const Toy toy;

  ASSERT_THAT(
      Sample(toy.WithMotions("--seconds 0.2 --count 3 --start sway:0.1")),
      IsOk());

  const Json json = toy.Read();
  EXPECT_EQ(json["ways"][2]["starts"], 1);
  EXPECT_EQ(json["ways"][2]["rows"][2]["start"], "sway at 0.10 s");
}

TEST(Sample, WritesAPageThatHoldsTheSamples) {
  const Toy toy;
  const std::string page = JoinPath(toy.world.folder, "samples.html");

  ASSERT_THAT(Sample(toy.WithMotions("--seconds 0.2 --count 2 --page " + page)),
              IsOk());

  // Two ways of one start, and two samples with noise.
  const auto html = ReadFile(page);
  ASSERT_THAT(html, IsOk());
  EXPECT_THAT(
      *html,
      AllOf(HasSubstr("\"samples\":true"), HasSubstr("id=\"trajectory-0\""),
            HasSubstr("zero action"), Not(HasSubstr("src=\"http"))));
}

TEST(Sample, RefusesABundleWithoutALatent) {
  const world::testing::ToyWorld world = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(world.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(world), bundle),
              IsOk());

  EXPECT_THAT(Sample("--bundle " + bundle + " --out " + bundle + ".json"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(bundle), HasSubstr("graph \"sample\""),
                             HasSubstr("found policy"))));
  EXPECT_FALSE(FileExists(bundle + ".json"));
}

TEST(Sample, NamesTheFlagThatIsWrong) {
  const Toy toy;
  const auto expect = [&](const std::string& flags, const char* message) {
    EXPECT_THAT(
        Sample(toy.Arguments(flags)),
        StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)))
        << flags;
  };

  expect("--seconds 0", "--seconds: expected > 0, found 0");
  expect("--count 0", "--count: expected >= 1, found 0");
  expect("--count 4 --per-start 3", "--per-start: expected a divisor");
  expect("--start fallen:1 --per-start 1", "--per-start: expected none");
  expect("--motions m --threshold 0", "--threshold: expected > 0");
  expect("--motions m --transitions 0", "--transitions: expected >= 1");
  expect("--student", "--student: expected --motions");
  expect("--start walk", "--start: expected clip, standing, fallen");
  expect("--start clip", "--motions");
  expect("--seconds 1e6", "control steps of all samples");
}

TEST(Sample, RefusesNumbersThatMeanNothing) {
  for (const char* flag :
       {"--noise=-1", "--noise nan", "--noise 1e39", "--seconds nan",
        "--seconds inf", "--threads=-5", "--motions m --threshold inf",
        "--motions m --threshold nan"}) {
    EXPECT_THROW(Sample(std::string("--bundle b ") + flag).IgnoreError(),
                 CLI::ValidationError)
        << flag;
  }
}

TEST(Sample, ComparesWithNothingWithoutALibrary) {
  for (const char* flag : {"--threshold 0.3", "--transitions 7"}) {
    EXPECT_THROW(Sample(std::string("--bundle b ") + flag).IgnoreError(),
                 CLI::RequiresError)
        << flag;
  }
}

TEST(Sample, BeginsInTheSameFallsWhateverTheSeed) {
  const Toy toy;
  const auto heights = [&](const char* seed) {
    EXPECT_THAT(Sample(toy.Arguments(std::string("--seconds 0.2 --count 2 "
                                                 "--seed ") +
                                     seed)),
                IsOk());
    // The zero action draws nothing.
    return std::make_pair(toy.Read()["ways"][0]["rows"],
                          toy.Read()["ways"][2]["rows"]);
  };

  const auto one = heights("1"), two = heights("2");

  EXPECT_EQ(one.first, two.first);
  EXPECT_NE(one.second, two.second);
}

TEST(Sample, TellsScalesApartThatAreAllButTheSame) {
  const Toy toy;

  ASSERT_THAT(Sample(toy.Arguments("--seconds 0.2 --count 2 --noise 1 "
                                   "--noise 1.0000001")),
              IsOk());

  const Json ways = toy.Read()["ways"];
  ASSERT_EQ(ways.size(), 4);
  EXPECT_EQ(ways[2]["name"], "noise 1");
  EXPECT_EQ(ways[3]["name"], "noise 1.0000001");
}

TEST(Sample, NamesWhatIsNotThere) {
  const Toy toy;

  EXPECT_THAT(Sample("--bundle " + toy.bundle + " --out /nowhere/s.json"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("/nowhere/s.json: expected a folder "
                                 "/nowhere")));

  EXPECT_THAT(Sample("--bundle /nowhere --out " + toy.out),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
  EXPECT_THAT(Sample(toy.Arguments("--motions /nowhere")),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

}  // namespace
}  // namespace sinew::tools
