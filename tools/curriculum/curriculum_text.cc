#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/curriculum/run_curriculum.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMaxNameWidth = 48;

double Percent(const Json& share) { return 100 * share.get<double>(); }

int NameWidth(const Json& rows, const char* key) {
  size_t width = 4;
  for (const Json& row : rows) {
    width = std::max(width, row[key].get_ref<const std::string&>().size());
  }
  return static_cast<int>(std::min(width, kMaxNameWidth));
}

// "2 of 8", and of the latest the share of starts and the error.
std::string Evaluations(const Json& clip) {
  if (clip["failed_latest"].is_null()) return "never evaluated";
  return absl::StrFormat("%d of %d failed; latest: %.0f %% of starts, %.0f mm",
                         clip["failed_evaluations"].get<int64_t>(),
                         clip["evaluations"].get<int64_t>(),
                         Percent(clip["succeeded_share"]),
                         clip["mean_error_mm"].get<double>());
}

std::string TrackingError(const Json& row) {
  const Json& error = row["tracking_error_mm"];
  return error.is_null() ? "-" : absl::StrFormat("%.0f", error.get<double>());
}

std::string LastSeen(const Json& row) {
  const auto iteration = row["last_seen"].get<int64_t>();
  return iteration < 0 ? "never" : absl::StrCat(iteration);
}

void AddSummary(const RunCurriculum& curriculum, const Json& json,
                std::string& text) {
  const learner::CurriculumSummary& summary = curriculum.summary;
  // Only where the recipe names some.
  const std::string drawn =
      summary.drawn_clips < summary.clips
          ? absl::StrCat(", starts from ", summary.drawn_clips, " of them")
          : "";
  absl::StrAppendFormat(
      &text,
      "%s, iteration %d: rule %s, %d clips (%d more left out)%s, %d bins\n",
      curriculum.run, curriculum.iteration,
      json["rule"].get_ref<const std::string&>(), summary.clips,
      summary.left_out_clips, drawn, summary.bins);
  absl::StrAppendFormat(
      &text,
      "entropy %.2f nats, %.0f %% of uniform; floor %.0f %% of starts; half of "
      "the starts in %d clips, at most %.1f %% in one\n",
      summary.entropy, 100 * summary.entropy_share, 100 * summary.floor_share,
      summary.clips_of_half, 100 * summary.largest_clip_share);
  absl::StrAppendFormat(
      &text,
      "failure rate of a passage %.1f %%; of the hardest tenth of the bins "
      "%.1f %%, with %.1f %% of the starts\n",
      100 * summary.failure_rate, 100 * summary.hardest_failure_rate,
      100 * summary.hardest_share);
  absl::StrAppendFormat(
      &text,
      "%d clips evaluated, %d failed the latest time; worst tenth: %.0f %% of "
      "starts\n",
      summary.evaluated_clips, summary.hard_clips, 100 * summary.worst_success);
}

void AddClips(const Json& clips, std::string& text) {
  const int width = NameWidth(clips, "name");
  absl::StrAppendFormat(&text,
                        "\nhardest clips\n%-*s %7s %7s %8s %7s %6s %9s  %s\n",
                        width, "clip", "starts", "failed", "rate", "share",
                        "mm", "last seen", "evaluations");
  for (const Json& clip : clips) {
    absl::StrAppendFormat(
        &text, "%-*s %7d %7d %6.1f %% %5.1f %% %6s %9s  %s\n", width,
        clip["name"].get_ref<const std::string&>(),
        clip["visits"].get<int64_t>(), clip["failures"].get<int64_t>(),
        Percent(clip["failure_rate"]), Percent(clip["probability"]),
        TrackingError(clip), LastSeen(clip), Evaluations(clip));
  }
}

void AddBins(const Json& bins, std::string& text) {
  const int width = NameWidth(bins, "clip");
  absl::StrAppendFormat(&text,
                        "\nhardest bins\n%-*s %13s %7s %7s %8s %7s %6s %9s\n",
                        width, "clip", "seconds", "starts", "failed", "rate",
                        "share", "mm", "last seen");
  for (const Json& bin : bins) {
    absl::StrAppendFormat(
        &text, "%-*s %5.1f - %5.1f %7d %7d %6.1f %% %5.1f %% %6s %9s\n", width,
        bin["clip"].get_ref<const std::string&>(), bin["from_s"].get<double>(),
        bin["to_s"].get<double>(), bin["visits"].get<int64_t>(),
        bin["failures"].get<int64_t>(), Percent(bin["failure_rate"]),
        Percent(bin["probability"]), TrackingError(bin), LastSeen(bin));
  }
}

void AddLeftOut(const Json& clips, std::string& text) {
  if (clips.empty()) return;
  const int width = NameWidth(clips, "name");
  absl::StrAppend(&text, "\nleft out of training\n");
  for (const Json& clip : clips) {
    absl::StrAppendFormat(&text, "%-*s  %s\n", width,
                          clip["name"].get_ref<const std::string&>(),
                          Evaluations(clip));
  }
}

}  // namespace

std::string CurriculumText(const RunCurriculum& curriculum, int hardest) {
  const Json json = CurriculumJson(curriculum, hardest);
  std::string text;
  AddSummary(curriculum, json, text);
  AddClips(json["clips"], text);
  AddBins(json["bins"], text);
  AddLeftOut(json["left_out"], text);
  return text;
}

}  // namespace sinew::tools
