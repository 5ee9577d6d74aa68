#include "tools/evaluation/figures_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/status.h"
#include "common/testing/matchers.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

Json Set(int clips, int succeeded, double error) {
  return {{"clips", clips},
          {"succeeded_clips", succeeded},
          {"frames", clips * 10},
          {"e_g_mpjpe_mm", error},
          {"e_mpjpe_mm", 20.04},
          {"e_acc", 3},
          {"e_vel", 4}};
}

// 9 of 12 clips: 7 of 8 trained on, 2 of 4 left out.
Json File() {
  Json file = {{"overall", Set(12, 9, 50)},      {"successful", Set(9, 9, 40)},
               {"zero_action", Set(12, 1, 150)}, {"library", {{"sha256", "l"}}},
               {"starts_per_clip", 1},           {"seconds", 10.0}};
  file["definitions"] = {{"fall_distance_m", 0.5}};
  file["training"] = Set(8, 7, 45);
  file["training"]["successful"] = Set(7, 7, 35.52);
  file["training"]["zero_action"] = Set(8, 1, 151);
  file["left_out"] = Set(4, 2, 60);
  file["left_out"]["successful"] = Set(2, 2, 55);
  file["left_out"]["zero_action"] = Set(4, 0, 152);
  return file;
}

TableRow Row(const std::string& name, const Json& file) {
  return {.name = name, .file = name + ".json", .json = file.dump()};
}

TEST(FiguresTable, ShowsErrorsOfTheSuccessfulByTrainedOnAndLeftOut) {
  Json other = File();
  other["imported"] = {{"clips", 15}, {"succeeded_clips", 9}};

  const auto table = FiguresTable({Row("expert", File()), Row("PHC+", other)});

  ASSERT_THAT(table, IsOk());
  const std::string cells =
      " 87.5 % (7/8) | 35.5 | 20.0 | 3.0 | 4.0 |"
      " 50.0 % (2/4) | 55.0 | 20.0 | 3.0 | 4.0 |";
  EXPECT_THAT(
      *table,
      AllOf(HasSubstr("| expert |" + cells + " - |\n"),
            HasSubstr("| PHC+ |" + cells + " 60.0 % (9/15) |\n"),
            HasSubstr("| zero action, errors until it fails |"
                      " 12.5 % (1/8) | 151.0 | 20.0 | 3.0 | 4.0 |"
                      " 0.0 % (0/4) | 152.0 | 20.0 | 3.0 | 4.0 | - |\n")));
}

TEST(FiguresTable, HasAZeroActionOfEachActionLaw) {
  Json absolute = File();
  absolute["training"]["zero_action"] = Set(8, 0, 251);

  const auto table =
      FiguresTable({Row("expert", File()), Row("student", absolute),
                    Row("no bottleneck", absolute)});

  ASSERT_THAT(table, IsOk());
  EXPECT_THAT(
      *table,
      AllOf(HasSubstr("| zero action of expert, errors until it fails |"
                      " 12.5 % (1/8) | 151.0 |"),
            HasSubstr("| zero action of student, no bottleneck, errors until "
                      "it fails | 0.0 % (0/8) | 251.0 |")));
}

TEST(FiguresTable, KeepsNamesInTheirCells) {
  const auto table = FiguresTable({Row("a|b <c>", File())});

  ASSERT_THAT(table, IsOk());
  EXPECT_THAT(*table, HasSubstr("| a\\|b &lt;c&gt; |"));
  EXPECT_THAT(FiguresTable({Row("", File())}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("name in the table: expected one")));
}

TEST(FiguresTable, TakesAllClipsForTrainedOnWhereNoneIsLeftOut) {
  Json file = File();
  file.erase("training");
  file.erase("left_out");
  file["successful"]["frames"] = 0;

  const auto table = FiguresTable({Row("expert", file)});

  ASSERT_THAT(table, IsOk());
  EXPECT_THAT(*table, HasSubstr("| expert | 75.0 % (9/12) | - | - | - | - |"
                                " - | - | - | - | - | - |\n"));
}

TEST(FiguresTable, NamesFileAndFieldOfWhatCannotBeCompared) {
  Json library = File(), seconds = File(), old = File();
  library["library"]["sha256"] = "m";
  seconds["seconds"] = 5.0;
  old["left_out"].erase("successful");
  Json randomised = File(), strict = File();
  randomised["randomised"] = {{"seed", 0}};
  strict["definitions"]["fall_distance_m"] = 0.25;
  const auto error = [](const Json& file) {
    return FiguresTable({Row("a", File()), Row("b", file)}).status();
  };
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

  EXPECT_THAT(error(library),
              StatusIs(kInvalid, HasSubstr("b.json: library.sha256: expected "
                                           "\"l\", found \"m\"")));
  EXPECT_THAT(error(seconds),
              StatusIs(kInvalid, HasSubstr("b.json: seconds: expected 10")));
  EXPECT_THAT(error(randomised),
              StatusIs(kInvalid, HasSubstr("b.json: randomised: expected null, "
                                           "found {\"seed\":0}")));
  EXPECT_THAT(
      error(strict),
      StatusIs(kInvalid, HasSubstr("b.json: definitions.fall_distance_m: "
                                   "expected 0.5, found 0.25")));
  EXPECT_THAT(error(old),
              StatusIs(kInvalid, HasSubstr("b.json: left_out.successful")));
  EXPECT_THAT(error(Json::array()), StatusIs(kInvalid, HasSubstr("b.json")));
  EXPECT_THAT(error({{"overall", 1}}),
              StatusIs(kInvalid, HasSubstr("b.json: overall")));
  EXPECT_THAT(FiguresTable({}), StatusIs(kInvalid, HasSubstr("found none")));
}

}  // namespace
}  // namespace sinew::evaluation
