#include "tools/training/teacher_choice.h"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/json_fields.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/world/start.h"
#include "teacher/clip_annotator.h"
#include "tools/evaluation/same_task.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::json;

constexpr char kFlag[] = "--teacher-eval";

// A file of the flag's, in errors.
std::string Named(const std::string& file) {
  return absl::StrCat(kFlag, " ", file);
}

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
  double minus_error_mm = 0;  // E_g-mpjpe until the falls

  friend auto operator<=>(const Score&, const Score&) = default;
};

// One candidate's evaluation.
struct Scores {
  std::string file;
  std::string manifest_sha256;
  std::map<std::string, Score> of_clip;
};

// Throws nlohmann's exceptions, which ReadScores catches.
Scores ParseScores(const Json& json) {
  Scores scores;
  scores.manifest_sha256 = json.at("bundle").at("manifest_sha256");
  (void)json.at("starts_per_clip").get<int64_t>();  // compared by CheckSameTask
  (void)json.at("seconds").get<double>();
  (void)json.at("definitions").at("fall_distance_m").get<double>();
  for (const Json& clip : json.at("clips")) {
    const Json& error = clip.at("e_g_mpjpe_mm");  // null: nothing compared
    scores.of_clip[clip.at("name")] = {
        .succeeded_starts = clip.at("succeeded_starts"),
        .frames = clip.at("frames"),
        .minus_error_mm = error.is_null()
                              ? -std::numeric_limits<double>::infinity()
                              : -error.get<double>()};
  }
  return scores;
}

// `json`: the file.
absl::StatusOr<Scores> ReadScores(const std::string& file,
                                  const motion::Library& library, Json* json) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  Scores scores;
  try {
    *json = Json::parse(text);
    scores = ParseScores(*json);
    const std::string digest = json->at("library").at("sha256");
    if (digest != library.digest()) {
      return UnfitField(Named(file), "library.sha256",
                        absl::StrCat(library.digest(), " of --motions"),
                        digest);
    }
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat(Named(file), ": expected what `sinew eval --out` writes ",
                     "of a bundle, found: ", error.what()));
  }
  scores.file = file;
  for (int c = 0; c < library.num_clips(); ++c) {
    const std::string& name = library.clip(c).name();
    if (scores.of_clip.contains(name)) continue;
    return UnfitField(Named(file), "clips", absl::StrCat("one named ", name),
                      "none");
  }
  return scores;
}

// By candidate; each has one.
absl::StatusOr<std::vector<Scores>> ScoresOf(
    absl::Span<const TeacherCandidate> candidates,
    absl::Span<const std::string> evaluations, const motion::Library& library) {
  std::map<std::string, Scores> found;  // by digest
  Json first;
  for (const std::string& file : evaluations) {
    Json json;
    SINEW_ASSIGN_OR_RETURN(Scores scores, ReadScores(file, library, &json));
    if (first.is_null()) first = json;
    const absl::Status same =
        evaluation::CheckSameTask(first, json, Named(file));
    if (!same.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(
          same.message(), "; expected is what ", evaluations[0], " has"));
    }
    const std::string digest = scores.manifest_sha256;
    if (std::ranges::none_of(candidates, [&](const TeacherCandidate& one) {
          return one.manifest_sha256 == digest;
        })) {
      return UnfitField(
          Named(file), "bundle.manifest_sha256",
          absl::StrCat("that of one in --teacher (", Names(candidates), ")"),
          digest);
    }
    const auto [other, is_new] = found.emplace(digest, std::move(scores));
    if (is_new) continue;
    return UnfitField(Named(file), "bundle.manifest_sha256",
                      absl::StrCat("another than that of ", other->second.file),
                      digest);
  }
  std::vector<Scores> result;
  for (const TeacherCandidate& one : candidates) {
    const auto scores = found.find(one.manifest_sha256);
    if (scores == found.end()) {
      return absl::InvalidArgumentError(absl::StrCat(
          kFlag, ": expected one evaluation of every bundle in --teacher, ",
          "found none of ", one.name, " (manifest_sha256 ", one.manifest_sha256,
          ")"));
    }
    result.push_back(scores->second);
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
  std::vector<int> in_order(candidates.size());
  std::iota(in_order.begin(), in_order.end(), 0);
  std::ranges::sort(in_order, {}, [&](int t) -> const std::string& {
    return candidates[t].manifest_sha256;
  });
  TeacherOfClip result;
  for (int c = 0; c < library.num_clips(); ++c) {
    const std::string& name = library.clip(c).name();
    result.push_back(*std::ranges::max_element(
        in_order, {}, [&](int t) { return scores[t].of_clip.at(name); }));
  }
  return result;
}

}  // namespace sinew::tools
