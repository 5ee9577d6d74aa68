#include "tools/report/page_data.h"

#include <algorithm>
#include <map>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/json_fields.h"
#include "tools/report/core_seconds.h"
#include "tools/report/curves.h"
#include "tools/report/reproduce.h"

namespace sinew::report {
namespace {

// Names of the clips, from whoever knows them.
std::vector<std::string> ClipNames(const RunRecord& run,
                                   const PageContext& context) {
  std::vector<std::string> names;
  for (const v1::ClipInfo& clip : context.library.clips()) {
    names.push_back(clip.name());
  }
  if (names.empty() && run.evaluation.is_object()) {
    for (const Json& clip : run.evaluation.value("clips", Json::array())) {
      names.push_back(TextAt(clip, {"name"}));
    }
  }
  return names;
}

std::string Title(const RunRecord& run, const PageContext& context) {
  const std::string recipe = RecipeOf(run).name();
  const std::vector<std::string> clips = ClipNames(run, context);
  const std::string what = clips.size() == 1 ? clips.front()
                           : clips.empty()
                               ? ""
                               : absl::StrCat(clips.size(), " clips");
  if (what.empty()) return recipe.empty() ? run.directory : recipe;
  return recipe.empty() ? what : absl::StrCat(what, " · ", recipe);
}

// Result: of eval.json, else of the last evaluation in training.
Json Result(const RunRecord& run) {
  if (run.evaluation.is_object() && run.evaluation.contains("overall") &&
      run.evaluation["overall"].is_object()) {
    Json result = run.evaluation["overall"];
    result["source"] = "eval.json";
    result["seconds"] = run.evaluation.value("seconds", Json());
    result["zero_action"] = run.evaluation.value("zero_action", Json());
    return result;
  }
  for (auto row = run.rows.rbegin(); row != run.rows.rend(); ++row) {
    if (!row->contains("eval") || !(*row)["eval"].is_object()) continue;
    Json result = (*row)["eval"];
    result["source"] = "training";
    result["seconds"] = RecipeOf(run).evaluation().seconds();
    return result;
  }
  return Json::object();
}

Json Headline(const RunRecord& run) {
  Json headline = Result(run);
  if (!run.rows.empty()) {
    const Json& last = run.rows.back();
    headline["minutes"] = NumberAt(last, {"train_s"}) / 60;
    headline["wall_minutes"] = NumberAt(last, {"wall_s"}) / 60;
    headline["samples"] = NumberAt(last, {"samples"});
    headline["iterations"] = NumberAt(last, {"iteration"});
  }
  return headline;
}

Json CoreSecondsObject(const std::vector<Json>& rows) {
  const CoreSeconds counted = CountCoreSeconds(rows);
  Json stages = Json::array();
  for (const Stage& stage : counted.stages) {
    stages.push_back({{"name", stage.name},
                      {"what", stage.what},
                      {"seconds", stage.seconds}});
  }
  return {{"cores", counted.cores},
          {"wall", counted.wall},
          {"total", counted.total},
          {"stages", std::move(stages)}};
}

Json Curriculum(const RunRecord& run, const PageContext& context) {
  Json curves = CurriculumCurves(run.rows);
  if (curves.empty()) return nullptr;
  Json curriculum =
      context.curriculum.is_object() ? context.curriculum : Json::object();
  curriculum["curves"] = std::move(curves);
  return curriculum;
}

Json Lag(const RunRecord& run) {
  std::map<int64_t, int64_t> counts;
  double reissued = 0;
  const int64_t of_recipe = RecipeOf(run).rollouts().max_policy_lag();
  for (const Json& row : run.rows) {
    ++counts[static_cast<int64_t>(
        NumberAt(row, {"policy_lag"}, static_cast<double>(of_recipe)))];
    reissued = std::max(reissued, NumberAt(row, {"orders_reissued"}));
  }
  Json object = {{"max", of_recipe}, {"reissued", reissued}};
  for (const auto& [lag, iterations] : counts) {
    object["counts"][absl::StrCat(lag)] = iterations;
  }
  return object;
}

Json Credits(const RunRecord& run, const PageContext& context) {
  Json credits = Json::array();
  for (const v1::ClipInfo& clip : context.library.clips()) {
    credits.push_back({{"name", clip.name()},
                       {"origin", clip.provenance()},
                       {"licence", clip.licence()}});
  }
  if (!credits.empty() || !run.manifest.is_object()) return credits;
  // Without the library: what the bundle says of it, "NAME: ORIGIN (LICENCE)".
  const Json provenance = run.manifest.value("provenance", Json::object());
  if (!provenance.is_object()) return credits;
  for (const Json& clip : provenance.value("clips", Json::array())) {
    if (clip.is_string()) credits.push_back({{"name", clip}});
  }
  return credits;
}

}  // namespace

Json MakePageData(const RunRecord& run, const PageContext& context) {
  return {
      {"title", Title(run, context)},
      {"run", run.directory},
      {"notes", run.notes},
      {"build", context.build},
      {"headline", Headline(run)},
      {"training", TrainingCurves(run.rows)},
      {"evaluations", EvaluationCurves(run.rows)},
      {"curriculum", Curriculum(run, context)},
      {"core_seconds", CoreSecondsObject(run.rows)},
      {"lag", Lag(run)},
      {"evaluation", run.evaluation},
      {"film", context.film},
      {"film_note", context.film_note},
      {"config", run.config},
      {"reproduce", ReproduceCommands(run, context.library, context.motions)},
      {"credits", Credits(run, context)},
      {"bundle", run.manifest}};
}

}  // namespace sinew::report
