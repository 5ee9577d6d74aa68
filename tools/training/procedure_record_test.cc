#include "tools/training/procedure_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_replace.h"
#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// One stage has ended, another is under way.
ProcedureRecord MakeRecord() {
  ProcedureRecord record;
  record.recipe_sha256 = "abc";
  record.assets = {{"library", "def"}, {"model", "012"}};
  record.library_clips = 5;
  record.trained_on_clips = 4;
  record.left_out_clips = 1;
  record.cleaned_away.emplace()["fly"] = "no floor";
  record.stages.resize(2);
  ProcedureRecord::Entry& first = record.stages[0];
  first.directory = "stages/00_primitive_0";
  first.decision.next = learner::Stage();
  first.decision.reason = "begins";
  first.finished = learner::FinishedStage{.stage = learner::Stage(),
                                          .plateau = true,
                                          .iterations = 3,
                                          .samples = 192,
                                          .train_seconds = 1.5,
                                          .best_share = 0.25,
                                          .stalled = 3,
                                          .failed = {"run", "jump"}};
  first.recovered = {.starts = 256, .within_3_s = 0.25, .within_5_s = 0.5};
  ProcedureRecord::Entry& second = record.stages[1];
  second.directory = "stages/01_primitive_0_hard";
  second.decision.next = learner::Stage{.kind = learner::StageKind::kHard,
                                        .primitive = 0,
                                        .from = 0,
                                        .clips = {"run", "jump"},
                                        .primitives = {7}};
  second.decision.reason = "goes on";
  second.decision.evidence = {.clips = 4,
                              .hard = {"run", "jump"},
                              .hard_before = 1,
                              .hard_won = 2,
                              .forgotten = 3};
  return record;
}

TEST(ProcedureRecord, IsReadBackAsItWasWritten) {
  const ProcedureRecord record = MakeRecord();

  const auto found = ParseProcedure(PrintProcedure(record), "file");

  ASSERT_THAT(found, IsOk());
  EXPECT_EQ(PrintProcedure(*found), PrintProcedure(record));
  EXPECT_EQ(found->cleaned_away, record.cleaned_away);
  ASSERT_THAT(found->stages, SizeIs(2));
  EXPECT_EQ(found->stages[1].decision.next, record.stages[1].decision.next);
  EXPECT_EQ(found->stages[1].decision.evidence,
            record.stages[1].decision.evidence);
  EXPECT_EQ(found->stages[1].decision.reason, "goes on");
  EXPECT_EQ(found->end, std::nullopt);
  EXPECT_THAT(found->Finished(), SizeIs(1));
  EXPECT_EQ(found->stages[0].recovered, record.stages[0].recovered);
  EXPECT_EQ(found->stages[1].recovered, std::nullopt);
  EXPECT_EQ(found->Finished()[0].best_share, 0.25);
  EXPECT_EQ(found->Finished()[0].stalled, 3);
  EXPECT_EQ(found->Finished()[0].failed, record.stages[0].finished->failed);
}

TEST(ProcedureRecord, MayBeOfAVersionThatDidNotCountWhoGetsUp) {
  ProcedureRecord record = MakeRecord();
  record.stages[0].recovered.reset();

  const auto found = ParseProcedure(PrintProcedure(record), "file");

  ASSERT_THAT(found, IsOk());
  EXPECT_TRUE(found->stages[0].finished.has_value());
  EXPECT_EQ(found->stages[0].recovered, std::nullopt);
  std::string text = PrintProcedure(MakeRecord());
  EXPECT_THAT(
      ParseProcedure(
          absl::StrReplaceAll(text, {{"\"within_3_s\"", "\"soon\""}}), "file"),
      StatusIs(absl::StatusCode::kDataLoss, HasSubstr("file")));
}

TEST(ProcedureRecord, KeepsWhyItIsOver) {
  ProcedureRecord record = MakeRecord();
  record.stages.pop_back();
  record.end = learner::Decision();
  record.end->reason = "nothing is left";
  record.end->evidence = {.clips = 4,
                          .hard = {"run"},
                          .hard_before = 2,
                          .hard_won = 1,
                          .forgotten = 0};

  const auto found = ParseProcedure(PrintProcedure(record), "file");

  ASSERT_THAT(found, IsOk());
  ASSERT_TRUE(found->end.has_value());
  EXPECT_EQ(found->end->reason, "nothing is left");
  EXPECT_EQ(found->end->evidence, record.end->evidence);
  EXPECT_EQ(found->end->next, std::nullopt);
}

// The hard stage, then the single primitive; samples: 192, 128, 128.
ProcedureRecord MakeComparedRecord() {
  ProcedureRecord record = MakeRecord();
  ProcedureRecord::Entry& hard = record.stages[1];
  hard.finished = learner::FinishedStage{.stage = *hard.decision.next,
                                         .samples = 128,
                                         .train_seconds = 1,
                                         .failed = {"run"}};
  ProcedureRecord::Entry& single = record.stages.emplace_back();
  single.directory = "stages/02_single";
  single.decision.next = learner::Stage{.kind = learner::StageKind::kSingle,
                                        .primitive = 0,
                                        .from = 0,
                                        .clips = {},
                                        .primitives = {},
                                        .samples = 128};
  single.decision.reason = "by itself";
  single.finished = learner::FinishedStage{.stage = *single.decision.next,
                                           .samples = 128,
                                           .train_seconds = 4,
                                           .failed = {}};
  return record;
}

TEST(ProcedureRecord, HasTheProcedureBesideTheSinglePrimitive) {
  const ProcedureRecord record = MakeComparedRecord();
  const std::string text = PrintProcedure(record);

  EXPECT_THAT(text, HasSubstr(R"(
  "samples": 320,
  "train_seconds": 2.5,
)"));
  EXPECT_THAT(text, HasSubstr(R"(
  "comparison": {
    "procedure": {
      "directory": "stages/01_primitive_0_hard",
      "samples": 320,
      "clips_failed": 1
    },
    "single": {
      "directory": "stages/02_single",
      "samples": 320,
      "clips_failed": 0
    }
  }
)"));
  const auto found = ParseProcedure(text, "file");
  ASSERT_THAT(found, IsOk());
  EXPECT_EQ(found->stages[2].decision.next, record.stages[2].decision.next);
  EXPECT_EQ(PrintProcedure(*found), text);
}

// So one that was begun before there was one goes on.
TEST(ProcedureRecord, SaysNothingOfASinglePrimitiveThatIsNotAskedFor) {
  const std::string text = PrintProcedure(MakeRecord());

  EXPECT_THAT(text, HasSubstr(R"(
        "forgotten": 0
      },
      "finished": {
)"));
  EXPECT_THAT(text, EndsWith(R"(
        "forgotten": 3
      }
    }
  ]
}
)"));
  const auto found = ParseProcedure(text, "file");
  ASSERT_THAT(found, IsOk());
  EXPECT_EQ(found->stages[1].decision.next->samples, 0);
}

TEST(ProcedureRecord, IsDecidedOnceOnlyTheSinglePrimitiveIsToEnd) {
  ProcedureRecord record = MakeComparedRecord();
  record.stages[2].finished.reset();
  EXPECT_TRUE(record.Decided());

  EXPECT_THAT(PrintProcedure(record), Not(HasSubstr("comparison")));
  record.stages.pop_back();
  EXPECT_FALSE(record.Decided());
  record.end = learner::Decision();
  EXPECT_TRUE(record.Decided());
  EXPECT_FALSE(ProcedureRecord().Decided());
}

TEST(ProcedureRecord, RefusesWhatIsNone) {
  const std::string good = PrintProcedure(MakeRecord());
  for (const std::string& bad :
       {std::string("{"), std::string("[]"),
        absl::StrReplaceAll(good, {{"\"from\"", "\"of\""}})}) {
    EXPECT_THAT(ParseProcedure(bad, "RUN/procedure.json"),
                StatusIs(absl::StatusCode::kDataLoss,
                         HasSubstr("RUN/procedure.json: expected the record "
                                   "of a procedure")));
  }
  EXPECT_THAT(
      ParseProcedure(absl::StrReplaceAll(good, {{"\"hard\",", "\"soft\","}}),
                     "file"),
      StatusIs(absl::StatusCode::kDataLoss,
               AllOf(HasSubstr("file"), HasSubstr("found \"soft\""))));
  EXPECT_THAT(
      ParseProcedure(absl::StrReplaceAll(good, {{"\"format_version\": 1",
                                                 "\"format_version\": 2"}}),
                     "file"),
      StatusIs(absl::StatusCode::kDataLoss, HasSubstr("expected 1, found 2")));
}

TEST(ProcedureRecord, RefusesPrimitivesThatThereCannotBe) {
  for (const int primitive : {-1, 17, 2000000000}) {
    ProcedureRecord record = MakeRecord();
    record.stages[1].decision.next->primitive = primitive;

    EXPECT_THAT(
        ParseProcedure(PrintProcedure(record), "file"),
        StatusIs(absl::StatusCode::kDataLoss,
                 AllOf(HasSubstr("file: stages.primitive: expected 0 to 16"),
                       HasSubstr(std::to_string(primitive)))));
  }
}

}  // namespace
}  // namespace sinew::tools
