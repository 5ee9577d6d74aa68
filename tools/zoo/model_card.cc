#include "tools/zoo/model_card.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/json_fields.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "tools/evaluation/figures_table.h"
#include "tools/zoo/card_chapters.h"
#include "tools/zoo/card_text.h"
#include "tools/zoo/trained_on.h"

namespace sinew::zoo {
namespace {

using Json = nlohmann::json;

std::string OrUnknown(const std::string& text) {
  return text.empty() ? "unknown" : evaluation::TableCell(text);
}

int64_t Parameters(const bundle::Bundle& bundle) {
  int64_t count = 0;
  for (const auto& [name, tensor] : bundle.weights) {
    count += tensor.num_elements();
  }
  return count;
}

std::string IntroductionChapter(const CardFacts& facts) {
  const v1::BundleManifest& manifest = facts.bundle.manifest;
  std::string text = absl::StrFormat(
      "# %s, %s\n\nA policy that makes the character %s follow reference "
      "motions: %d joints, %d tracked bodies, %g control steps a second, "
      "observation %d, action %d.\n\n",
      OrUnknown(facts.run.recipe), evaluation::TableCell(manifest.character()),
      evaluation::TableCell(manifest.character()), manifest.joints_size(),
      manifest.bodies_size(), manifest.control_hz(),
      manifest.observation_width(), manifest.action_width());
  absl::StrAppend(&text, "| | |\n|---|---|\n| graphs | ",
                  absl::StrJoin(manifest.graphs(), ", "), " |\n");
  if (manifest.latent_width() > 0) {
    absl::StrAppend(&text, "| latent | ", manifest.latent_width(), " |\n");
  }
  absl::StrAppend(&text, "| numbers in weights | ", Parameters(facts.bundle),
                  " |\n| bundle | ", facts.bundle_bytes,
                  " bytes |\n| manifest SHA-256 | ", manifest.manifest_sha256(),
                  " |\n| character SHA-256 | ", manifest.character_sha256(),
                  " |\n");
  return text;
}

std::string Machine(const CardFacts& facts) {
  if (!facts.machine.empty()) return evaluation::TableCell(facts.machine);
  if (facts.run.cores == 0) return "unknown";
  return absl::StrCat(facts.run.cores, " cores, ",
                      OrUnknown(facts.run.cpu_class));
}

std::string SourceRow(const v1::BundleSource& source) {
  std::string role = evaluation::TableCell(source.role());
  if (const int clips = source.labelled().clips_size(); clips > 0) {
    absl::StrAppend(&role, " of ", clips, clips == 1 ? " clip" : " clips");
  }
  return absl::StrCat("| ", role, " | ", OrUnknown(source.recipe()), ", ",
                      source.manifest_sha256(), " |\n");
}

// Which of several teachers labelled which clips.
std::string LabelledClips(const v1::BundleProvenance& provenance) {
  std::string text;
  for (const v1::BundleSource& source : provenance.sources()) {
    const auto& clips = source.labelled().clips();
    if (clips.empty()) continue;
    absl::StrAppend(&text, "\n", OrUnknown(source.recipe()), ", ",
                    source.manifest_sha256(), ": ",
                    evaluation::TableCell(absl::StrJoin(clips, ", ")), ".\n");
  }
  if (text.empty()) return text;
  return absl::StrCat(
      "\n<details><summary>Which teacher labelled what"
      "</summary>\n",
      text, "\n</details>\n");
}

std::string TrainingChapter(const CardFacts& facts) {
  const v1::BundleProvenance& provenance = facts.bundle.manifest.provenance();
  std::string text = absl::StrFormat(
      "%s\n\n| | |\n|---|---|\n| recipe | %s |\n| recipe SHA-256 | "
      "%s |\n| seed | %d |\n| samples | %d |\n| time | %.2f h of training, "
      "evaluation left out |\n| iterations (of its last stage) | %d |\n"
      "| machine | %s |\n| build | %s |\n",
      kTraining, OrUnknown(facts.run.recipe), provenance.recipe_sha256(),
      facts.run.seed, facts.run.samples, facts.run.train_seconds / 3600,
      provenance.iterations(), Machine(facts), OrUnknown(provenance.build()));
  for (const v1::BundleSource& source : provenance.sources()) {
    absl::StrAppend(&text, SourceRow(source));
  }
  absl::StrAppend(&text, LabelledClips(provenance));
  if (facts.run.decisions.empty()) return text;
  absl::StrAppend(&text, "\nIts procedure, in its own words:\n\n");
  for (const std::string& decision : facts.run.decisions) {
    absl::StrAppend(&text, "1. ", evaluation::TableCell(decision), "\n");
  }
  return text;
}

std::string FallenText(const Json& fallen) {
  if (!fallen.is_object()) return "";
  std::string text = absl::StrFormat(
      "\nOf %d fallen starts, %.1f %% stand and track again within 3 s, %.1f "
      "%% within 5 s (zero action: %.1f %%, %.1f %%).\n",
      static_cast<int64_t>(NumberAt(fallen, {"starts"})),
      100 * NumberAt(fallen, {"recovered_3_s"}),
      100 * NumberAt(fallen, {"recovered_5_s"}),
      100 * NumberAt(fallen, {"zero_action", "recovered_3_s"}),
      100 * NumberAt(fallen, {"zero_action", "recovered_5_s"}));
  if (!fallen.contains("get_up")) return text;
  absl::StrAppendFormat(
      &text,
      "With the library's nearest get-up for a reference and, once that is "
      "over, its nearest frame that stays up: %.1f %%, %.1f "
      "%% (zero action: %.1f %%, %.1f %%).\n",
      100 * NumberAt(fallen, {"get_up", "recovered_3_s"}),
      100 * NumberAt(fallen, {"get_up", "recovered_5_s"}),
      100 * NumberAt(fallen, {"get_up", "zero_action", "recovered_3_s"}),
      100 * NumberAt(fallen, {"get_up", "zero_action", "recovered_5_s"}));
  return text;
}

// A number as a cell; "-": it is not known.
std::string NumberCell(const Json& at, const char* field, int decimals) {
  const Json number = at.is_object() ? at.value(field, Json()) : Json();
  if (!number.is_number()) return "-";
  return absl::StrFormat("%.*f", decimals, number.get<double>());
}

std::string ShareCell(const Json& at, const char* field) {
  const Json share = at.value(field, Json());
  if (!share.is_number()) return "-";
  return absl::StrFormat("%.1f %%", 100 * share.get<double>());
}

// How the motions look that a prior makes.
std::string MotionCells(const Json& way) {
  return absl::StrCat(
      NumberCell(way.value("transitions", Json()), "distance", 3), " | ",
      NumberCell(way.value("diversity", Json()), "over_time_m", 3), " | ",
      NumberCell(way, "foot_skate_m_per_s", 3), " | ",
      NumberCell(way, "joint_speed_rad_per_s", 2), " | ",
      NumberCell(way.value("latent", Json()), "ratio", 2));
}

std::string SamplesText(const Json& samples) {
  if (!samples.is_object()) return "";
  std::string text = absl::StrFormat(
      "\n%s%g s from starts `%s`, of %d transitions of the "
      "library (threshold %g):\n\n"
      "| | samples | upright at the end | got up | covered | of what tracking "
      "covers | distance | diversity, m | foot skate, m/s | joints, rad/s | "
      "steps of the latent |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      kPriorAlone, NumberAt(samples, {"seconds"}), samples.value("start", ""),
      static_cast<int64_t>(NumberAt(samples, {"library", "transitions"})),
      NumberAt(samples, {"library", "threshold"}));
  for (const Json& way : samples["ways"]) {
    const Json transitions = way.value("transitions", Json::object());
    absl::StrAppend(
        &text, "| ", evaluation::TableCell(way.value("name", "")), " | ",
        static_cast<int64_t>(NumberAt(way, {"samples"})), " | ",
        ShareCell(way, "upright_share"), " | ", ShareCell(way, "got_up_share"),
        " | ", ShareCell(transitions, "coverage"), " | ",
        ShareCell(way, "student_coverage"), " | ", MotionCells(way), " |\n");
  }
  absl::StrAppend(&text,
                  "\nUpright: of the samples that began so; got up: of the "
                  "others; distance: to the nearest transition of the library; "
                  "diversity: of bodies between two samples of one start, "
                  "relative to the root; steps of the latent: as a share of "
                  "its spread; -: none, or not measured.\n");
  return text;
}

// Clips that the library leaves out and the bundle says were trained on all the
// same, as where it was trained with another library.
int SeenOfLeftOut(const CardFacts& facts) {
  const bundle::ClipUses uses =
      bundle::ClipUsesOf(facts.bundle.manifest.provenance());
  int seen = 0;
  for (const v1::ClipInfo& clip : facts.library.clips()) {
    const auto use = uses.find(clip.name());
    if (!clip.left_out() || use == uses.end()) continue;
    seen += use->second == v1::CLIP_USE_TRAINED_ON ||
                    use->second == v1::CLIP_USE_SOURCE_TRAINED_ON
                ? 1
                : 0;
  }
  return seen;
}

// "608 of 700 starts, 58 of 70 clips from their first frame".
std::string StartsOf(const Json& set) {
  return absl::StrFormat(
      "%d of %d starts, %s of %d clips from their first frame",
      static_cast<int64_t>(NumberAt(set, {"succeeded_starts"})),
      static_cast<int64_t>(NumberAt(set, {"starts"})),
      NumberCell(set, "first_start_successes", 0),
      static_cast<int64_t>(NumberAt(set, {"clips"})));
}

std::string StartsText(const Json& evaluation) {
  const Json left_out = evaluation.value("left_out", Json());
  const Json own =
      evaluation.value("training", evaluation.value("overall", Json()));
  std::string text = absl::StrCat("It wins ", StartsOf(own));
  if (left_out.is_object()) {
    absl::StrAppend(&text, "; of those left out ", StartsOf(left_out));
  }
  return absl::StrCat(text, ".");
}

absl::StatusOr<std::string> MetricsChapter(const CardFacts& facts) {
  std::string text = absl::StrCat(kMetrics, "\n\n");
  if (facts.evaluation.is_object()) {
    SINEW_ASSIGN_OR_RETURN(
        const std::string table,
        evaluation::FiguresTable(
            {{.name = facts.run.recipe.empty() ? "unknown" : facts.run.recipe,
              .file = facts.evaluation_file,
              .json = facts.evaluation.dump()}}));
    absl::StrAppend(
        &text, table,
        "\nA clip succeeds (Succ) if its bodies' mean distance from the "
        "reference stays small at every start; errors, of clips that succeed: "
        "mm, mm, mm/frame^2, mm/frame at 30 Hz. ",
        NumberAt(facts.evaluation, {"starts_per_clip"}), " starts a clip, ",
        NumberAt(facts.evaluation, {"seconds"}), " s of those that loop. ",
        StartsText(facts.evaluation));
    if (facts.library_sha256 !=
        facts.bundle.manifest.provenance().library_sha256()) {
      absl::StrAppend(&text, " Evaluated on another library than trained on: ",
                      facts.library_sha256, ".");
    }
    if (const int seen = SeenOfLeftOut(facts); seen > 0) {
      absl::StrAppend(&text, " Of the clips that this library leaves out, ",
                      seen, " were trained on.");
    }
    absl::StrAppend(&text, "\n");
  } else {
    absl::StrAppend(&text, "Not evaluated.\n");
  }
  absl::StrAppend(&text, FallenText(facts.fallen), SamplesText(facts.samples));
  return text;
}

}  // namespace

absl::StatusOr<std::string> ModelCard(const CardFacts& facts) {
  SINEW_ASSIGN_OR_RETURN(const std::string metrics, MetricsChapter(facts));
  return absl::StrJoin(
      {IntroductionChapter(facts), TrainedOnChapter(facts),
       TrainingChapter(facts), metrics, LimitationsChapter(facts),
       ReproduceChapter(facts), LoadChapter(facts)},
      "\n");
}

}  // namespace sinew::zoo
