#include "tools/report/reproduce.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "common/json_fields.h"

namespace sinew::report {
namespace {

constexpr char kLibrary[] = "runs/again/library";
// Beyond so many a command line is no help.
constexpr size_t kMostFiles = 8;
// What `sinew motion import` takes without --rate, and `sinew train` without
// --character.
constexpr double kUsualRate = 30;
constexpr char kUsualCharacter[] = "humanoid";
// Frames by which a whole file and its clip differ at most: rounding, and
// whether a loop's last frame counts.
constexpr double kWholeWithin = 2.5;

// Whether the clip is all of its file: a trim or a cut loop is shorter.
bool IsWhole(const v1::ClipInfo& clip, double rate) {
  if (clip.source().duration_s() <= 0) return true;  // not known
  const double frames = clip.source().duration_s() * rate;
  return std::abs(static_cast<double>(clip.num_frames()) - frames) <=
         kWholeWithin;
}

// Empty where the manifest does not tell enough.
std::string ImportCommand(const v1::MotionLibrary& library) {
  std::set<std::string> files;
  int mirrors = 0;
  for (const v1::ClipInfo& clip : library.clips()) {
    // Neither the pieces of a blend nor the share that is left out is there.
    if (clip.has_blend() || clip.left_out() || clip.source_file().empty() ||
        !IsWhole(clip, library.frames_per_second())) {
      return "";
    }
    mirrors += clip.mirror_of().empty() ? 0 : 1;
    files.insert(clip.source_file());
  }
  if (files.empty() || files.size() > kMostFiles) return "";
  if (mirrors > 0 && 2 * mirrors != library.clips_size()) return "";
  std::string command =
      absl::StrCat("./sinew motion import --character ",
                   ShellWord(library.character()), " --out ", kLibrary);
  if (library.frames_per_second() != kUsualRate) {
    absl::StrAppendFormat(&command, " --rate %g", library.frames_per_second());
  }
  if (mirrors > 0) absl::StrAppend(&command, " --mirror");
  for (const std::string& file : files) {
    absl::StrAppend(&command, " ", ShellWord(file));
  }
  return command;
}

std::string CharacterOf(const RunRecord& run,
                        const v1::MotionLibrary& library) {
  const std::string name = TextAt(run.manifest, {"character"});
  return name.empty() ? library.character() : name;
}

// Bundles of a role that the run's bundle says it was made from.
int CountSources(const RunRecord& run, const char* role) {
  const Json* sources = FieldAt(run.manifest, {"provenance", "sources"});
  if (sources == nullptr) return 0;
  return static_cast<int>(std::count_if(
      sources->begin(), sources->end(),
      [&](const Json& source) { return TextAt(source, {"role"}) == role; }));
}

// " --flag BUNDLE BUNDLE", nothing for none.
std::string Bundles(const char* flag, int count) {
  std::string words = count > 0 ? absl::StrCat(" ", flag) : "";
  for (int i = 0; i < count; ++i) absl::StrAppend(&words, " BUNDLE");
  return words;
}

std::string TrainCommand(const RunRecord& run, const v1::MotionLibrary& library,
                         const std::string& motions) {
  std::string train =
      absl::StrCat("./sinew train --recipe ",
                   ShellWord(absl::StrCat(run.directory, "/config.textproto")),
                   " --motions ", motions, " --run runs/again");
  const std::string character = CharacterOf(run, library);
  if (!character.empty() && character != kUsualCharacter) {
    absl::StrAppend(&train, " --character ", ShellWord(character));
  }
  if (!run.rows.empty()) {
    absl::StrAppendFormat(&train, " --iterations %.0f",
                          NumberAt(run.rows.back(), {"iteration"}));
  }
  const v1::Recipe recipe = RecipeOf(run);
  // Of bundles the run knows the digests alone; without its own bundle, that
  // the recipe needs some.
  absl::StrAppend(&train, Bundles("--init", CountSources(run, "init")));
  absl::StrAppend(&train,
                  Bundles("--primitives",
                          std::max(CountSources(run, "primitive"),
                                   recipe.network().composer().primitives())));
  if (recipe.has_distillation()) {
    absl::StrAppend(&train, Bundles("--teacher",
                                    std::max(1, CountSources(run, "teacher"))));
  }
  return train;
}

}  // namespace

Json ReproduceCommands(const RunRecord& run, const v1::MotionLibrary& library,
                       const std::string& motions) {
  Json commands = Json::array();
  std::string folder = ShellWord(motions.empty() ? "LIBRARY" : motions);
  if (const std::string import = ImportCommand(library); !import.empty()) {
    commands.push_back(import);
    folder = kLibrary;
  }
  commands.push_back(TrainCommand(run, library, folder));
  const Json& eval = run.evaluation;
  commands.push_back(absl::StrFormat(
      "./sinew eval --bundle runs/again/%s --motions %s --out "
      "runs/again/eval.json --seconds %g --starts %g",
      absl::EndsWith(run.bundle, "bundle_best") ? "bundle_best" : "bundle",
      folder, NumberAt(eval, {"seconds"}, 10),
      NumberAt(eval, {"starts_per_clip"}, 32)));
  commands.push_back(
      absl::StrCat("./sinew report --run runs/again --motions ", folder));
  return commands;
}

std::string ShellWord(const std::string& word) {
  const bool plain =
      !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
        return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
               std::string_view("-_./=+:,@%").find(c) != std::string_view::npos;
      });
  if (plain) return word;
  return absl::StrCat("'", absl::StrReplaceAll(word, {{"'", "'\\''"}}), "'");
}

}  // namespace sinew::report
