#include "tools/report/testing/run_rows.h"

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::report::testing {
namespace {

Json Row(int iteration) {
  Json row = {
      {"iteration", iteration},
      {"wall_s", 2.0 * iteration},
      {"train_s", 1.5 * iteration},
      {"samples", 1000 * iteration},
      {"reward", 0.5 + 0.01 * iteration},
      {"reward_terms", {0.1, 0.2, 0.3, 0.4}},
      {"body_distance_m", 0.05},
      {"episodes", 10},
      {"failed_episodes", 5},
      {"kl", 0.02},
      {"cores", 2},
      {"ranks", 2},
      {"seconds", {{"simulate", 1.5}, {"infer", 0.25}, {"learn", 0.5}}}};
  if (iteration % 5 == 0) {
    row["eval"] = {{"iteration", iteration},
                   {"starts", 32},
                   {"succeeded_starts", 8},
                   {"survived_share", 0.5},
                   {"e_g_mpjpe_mm", 60.0}};
  }
  return row;
}

}  // namespace

std::vector<Json> Rows(int count) {
  std::vector<Json> rows;
  for (int i = 1; i <= count; ++i) rows.push_back(Row(i));
  return rows;
}

std::vector<Json> RowsWithCurriculum(int count) {
  std::vector<Json> rows = Rows(count);
  for (int i = 0; i < count; ++i) {
    rows[i]["curriculum"] = {{"clips", 4},
                             {"bins", 8},
                             {"entropy_share", 0.9},
                             {"floor_share", 0.1},
                             {"hardest_share", 0.25},
                             {"evaluated_clips", i < 2 ? 0 : 4},
                             {"hard_clips", i < 2 ? 0 : 1},
                             {"worst_success", i < 2 ? 0 : 0.5}};
  }
  return rows;
}

std::string MetricsText(const std::vector<Json>& rows) {
  std::string text;
  for (const Json& row : rows) absl::StrAppend(&text, row.dump(), "\n");
  return text;
}

void WriteRun(const std::string& folder) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.set_name("toy_recipe");
  SINEW_CHECK(RemoveRecursively(folder).ok());
  SINEW_CHECK(MakeDirectories(folder).ok());
  SINEW_CHECK(WriteFileAtomically(JoinPath(folder, "metrics.jsonl"),
                                  MetricsText(Rows(20)))
                  .ok());
  SINEW_CHECK(WriteFileAtomically(JoinPath(folder, "config.textproto"),
                                  PrintRecipe(recipe))
                  .ok());
}

}  // namespace sinew::report::testing
