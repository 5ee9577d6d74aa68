#include "tools/training/teacher_choice.h"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/world/start.h"
#include "teacher/clip_annotator.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::json;

constexpr char kFlag[] = "--teacher-eval";

std::string Names(absl::Span<const TeacherCandidate> candidates) {
  return absl::StrJoin(candidates, ", ",
                       [](std::string* out, const TeacherCandidate& one) {
                         out->append(one.name);
                       });
}

// How a candidate does on a clip, the better the greater.
struct Score {
  int64_t succeeded_starts = 0;
  int64_t frames = 0;

  friend auto operator<=>(const Score&, const Score&) = default;
};

// What an evaluation says, of what a choice depends on.
struct Scores {
  std::string file;
  std::string manifest_sha256;
  std::string library_sha256;
  int64_t starts_per_clip = 0;
  double seconds = 0;
  std::map<std::string, Score> of_clip;
};

// Throws nlohmann's exceptions, which ReadScores catches.
Scores ParseScores(const Json& json) {
  Scores scores;
  scores.manifest_sha256 = json.at("bundle").at("manifest_sha256");
  scores.library_sha256 = json.at("library").at("sha256");
  scores.starts_per_clip = json.at("starts_per_clip");
  scores.seconds = json.at("seconds");
  for (const Json& clip : json.at("clips")) {
    scores.of_clip[clip.at("name")] = {
        .succeeded_starts = clip.at("succeeded_starts"),
        .frames = clip.at("frames")};
  }
  return scores;
}

absl::StatusOr<Scores> ReadScores(const std::string& file) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  try {
    Scores scores = ParseScores(Json::parse(text));
    scores.file = file;
    return scores;
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat(kFlag, " ", file, ": expected what `sinew eval --out` ",
                     "writes of a bundle, found: ", error.what()));
  }
}

absl::Status Expected(const Scores& scores, const char* field,
                      const std::string& expected, const std::string& found) {
  return absl::InvalidArgumentError(absl::StrCat(kFlag, " ", scores.file, ": ",
                                                 field, ": expected ", expected,
                                                 ", found ", found));
}

// That it is of this library, with the starts of `first`.
absl::Status CheckScores(const Scores& scores, const Scores& first,
                         const motion::Library& library) {
  if (scores.library_sha256 != library.digest()) {
    return Expected(scores, "library.sha256",
                    absl::StrCat(library.digest(), " of --motions"),
                    scores.library_sha256);
  }
  if (scores.starts_per_clip != first.starts_per_clip) {
    return Expected(scores, "starts_per_clip",
                    absl::StrCat(first.starts_per_clip, " as ", first.file),
                    absl::StrCat(scores.starts_per_clip));
  }
  if (scores.seconds != first.seconds) {
    return Expected(scores, "seconds",
                    absl::StrCat(first.seconds, " as ", first.file),
                    absl::StrCat(scores.seconds));
  }
  for (int c = 0; c < library.num_clips(); ++c) {
    const std::string& name = library.clip(c).name();
    if (scores.of_clip.contains(name)) continue;
    return Expected(scores, "clips", absl::StrCat("one named ", name), "none");
  }
  return absl::OkStatus();
}

// By candidate; each has one.
absl::StatusOr<std::vector<Scores>> ScoresOf(
    absl::Span<const TeacherCandidate> candidates,
    absl::Span<const std::string> evaluations, const motion::Library& library) {
  std::vector<std::optional<Scores>> found(candidates.size());
  std::optional<Scores> first;
  for (const std::string& file : evaluations) {
    SINEW_ASSIGN_OR_RETURN(Scores scores, ReadScores(file));
    if (!first) first = scores;
    SINEW_RETURN_IF_ERROR(CheckScores(scores, *first, library));
    bool is_of_one = false;
    for (size_t t = 0; t < candidates.size(); ++t) {
      if (candidates[t].manifest_sha256 != scores.manifest_sha256) continue;
      if (found[t]) {
        return Expected(scores, "bundle",
                        absl::StrCat("another than that of ", found[t]->file),
                        absl::StrCat("the same, ", candidates[t].name));
      }
      found[t] = scores;
      is_of_one = true;
    }
    if (!is_of_one) {
      return Expected(scores, "bundle.manifest_sha256",
                      absl::StrCat("that of a bundle in --teacher (",
                                   Names(candidates), ")"),
                      scores.manifest_sha256);
    }
  }
  std::vector<Scores> result;
  for (size_t t = 0; t < candidates.size(); ++t) {
    if (!found[t]) {
      return absl::InvalidArgumentError(
          absl::StrCat(kFlag,
                       ": expected one evaluation of every bundle in "
                       "--teacher, found none of ",
                       candidates[t].name, " (manifest_sha256 ",
                       candidates[t].manifest_sha256, ")"));
    }
    result.push_back(*std::move(found[t]));
  }
  return result;
}

}  // namespace

absl::StatusOr<TeacherOfClip> ChooseByTraining(
    absl::Span<const TeacherCandidate> candidates, const v1::Start& start,
    const motion::Library& library) {
  std::vector<int> narrowest_first(candidates.size());
  std::iota(narrowest_first.begin(), narrowest_first.end(), 0);
  std::ranges::sort(narrowest_first, {}, [&](int t) {
    return std::pair(candidates[t].clips.size(), t);
  });
  TeacherOfClip result(library.num_clips(), teacher::ClipAnnotator::kNone);
  for (int c = 0; c < library.num_clips(); ++c) {
    const v1::ClipInfo& clip = library.clip(c);
    std::vector<int> teachers;
    for (const int t : narrowest_first) {
      if (candidates[t].clips.contains(clip.name())) teachers.push_back(t);
    }
    if (!teachers.empty()) result[c] = teachers[0];
    if (!world::IsDrawn(start, clip)) continue;
    if (teachers.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--teacher: expected a bundle that was trained on clip ",
                       clip.name(), ", found none among ", Names(candidates)));
    }
    const size_t fewest = candidates[teachers[0]].clips.size();
    if (teachers.size() > 1 && candidates[teachers[1]].clips.size() == fewest) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--teacher: expected one bundle that was trained on fewer clips than "
          "all others that were trained on clip ",
          clip.name(), ", found ", candidates[teachers[0]].name, " and ",
          candidates[teachers[1]].name, " of ", fewest,
          fewest == 1 ? " clip" : " clips", " each (", kFlag,
          " decides by how well they do)"));
    }
  }
  return result;
}

absl::StatusOr<TeacherOfClip> ChooseByEvaluation(
    absl::Span<const TeacherCandidate> candidates,
    absl::Span<const std::string> evaluations, const motion::Library& library) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<Scores> scores,
                         ScoresOf(candidates, evaluations, library));
  TeacherOfClip result;
  for (int c = 0; c < library.num_clips(); ++c) {
    const std::string& name = library.clip(c).name();
    const auto best = std::ranges::max_element(
        scores, {},
        [&](const Scores& of_one) { return of_one.of_clip.at(name); });
    result.push_back(static_cast<int>(best - scores.begin()));
  }
  return result;
}

}  // namespace sinew::tools
