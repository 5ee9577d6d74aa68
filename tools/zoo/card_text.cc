#include "tools/zoo/card_text.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/json_fields.h"
#include "common/policy/ports.h"
#include "tools/evaluation/figures_table.h"
#include "tools/zoo/card_chapters.h"

namespace sinew::zoo {
namespace {

using evaluation::TableCell;
using Json = nlohmann::json;

bool Failed(const Json& clip) {
  const auto success = clip.find("success");
  return success != clip.end() && *success == false;
}

// When a clip fails first, or nothing.
std::string FailedAt(const Json& clip, double frames_per_second) {
  const double frame = NumberAt(clip, {"failed_at_frame"});
  if (frame < 0 || !(frames_per_second > 0)) return "-";
  return absl::StrFormat("%.1f s", frame / frames_per_second);
}

std::string ClipRow(const CardFacts& facts, const Json& clip) {
  const auto named = clip.find("name");
  const std::string name = named != clip.end() && named->is_string()
                               ? named->get<std::string>()
                               : "?";
  double force = 0;
  for (const v1::ClipInfo& info : facts.library.clips()) {
    if (info.name() != name) continue;
    force = info.quality().residual_force_bodyweights();
  }
  // Evaluations of bundles that do not say know what the library leaves out.
  const auto said = clip.find("use");
  const std::string use = said != clip.end() && said->is_string()
                              ? said->get<std::string>()
                          : clip.contains("left_out") ? "left out"
                                                      : "trained on";
  const double rate = facts.library.frames_per_second();
  const auto zero = clip.find("zero_action");
  return absl::StrFormat(
      "| %s | %s | %s | %.0f mm | %s | %.2f |\n", TableCell(name),
      TableCell(use), FailedAt(clip, rate), NumberAt(clip, {"e_g_mpjpe_mm"}),
      zero == clip.end() ? "-" : FailedAt(*zero, rate), force);
}

// `.onnx` alone, where the C interface is of no use.
std::string PythonSnippet(const CardFacts& facts) {
  const auto ports = policy::FindPorts(facts.bundle.graph, "policy");
  const std::string input = ports.ok() ? ports->observation : "observation";
  const std::string output = ports.ok() ? ports->action : "action";
  return absl::StrCat(
      "```python\n"
      "import numpy, onnxruntime\n"
      "policy = onnxruntime.InferenceSession(\"bundle/policy.onnx\")\n"
      "feed = {x.name: numpy.zeros((1, x.shape[1]), numpy.float32)\n"
      "        for x in policy.get_inputs()}\n"
      "feed[\"",
      input, "\"][0] = observation  # [",
      facts.bundle.manifest.observation_width(),
      "], blocks as in manifest.json\n"
      "action, = policy.run([\"",
      output, "\"], feed)  # [1, ", facts.bundle.manifest.action_width(),
      "]\n```\n");
}

// The flags by which a run takes its sources.
std::string SourceFlags(const v1::BundleProvenance& provenance) {
  std::string flags;
  for (const auto& [role, flag] :
       {std::pair("init", "--init"), std::pair("primitive", "--primitives"),
        std::pair("teacher", "--teacher")}) {
    std::string bundles;
    for (const v1::BundleSource& source : provenance.sources()) {
      if (source.role() != role) continue;
      absl::StrAppend(&bundles, " ",
                      source.recipe().empty() ? "BUNDLE" : source.recipe());
    }
    if (!bundles.empty()) absl::StrAppend(&flags, " ", flag, bundles);
  }
  return flags;
}

// Of bundles that others steer by what lies in the latent.
std::string LatentSnippet(const v1::BundleManifest& manifest) {
  const int64_t width = manifest.latent_width();
  if (width == 0) return "";
  const auto& blocks = manifest.task().observation().blocks();
  const bool sees_target =
      std::find(blocks.begin(), blocks.end(),
                v1::Observation::BLOCK_PREVIOUS_TARGET) != blocks.end();
  return absl::StrCat(
      "\nWithout any reference, by its latent of ", width,
      " numbers (no library is loaded then):\n\n```c\n",
      sees_target ? "sinew_reset(policy, &state, NULL);  /* once: no target "
                    "came before */\n"
                  : "",
      "double mean[", width, "], std[", width,
      "];\nsinew_prior(policy, &state, mean, std, ", width,
      ");  /* likely moves */\nsinew_decode(policy, &state, mean, ", width,
      ", target);  /* or your own */\n```\n");
}

}  // namespace

std::string LimitationsChapter(const CardFacts& facts) {
  std::string text = absl::StrCat(kLimitations, "\n\n");
  const auto clips = facts.evaluation.find("clips");
  if (clips == facts.evaluation.end() || !clips->is_array()) {
    return absl::StrCat(text,
                        "Not evaluated: nothing is known of its limits."
                        "\n");
  }
  int failed = 0;
  std::string rows;
  for (const Json& clip : *clips) {
    if (!clip.is_object() || !Failed(clip)) continue;
    ++failed;
    absl::StrAppend(&rows, ClipRow(facts, clip));
  }
  absl::StrAppend(&text, failed, " of ", clips->size(), " clips fail.");
  absl::StrAppend(
      &text, " It has seen no motions but those above, on a flat floor.\n");
  if (failed == 0) return text;
  absl::StrAppend(
      &text,
      "\nForce: what joints and floor cannot explain of the motion, mean, in "
      "body weights; far above 0.1, no policy can follow.\n\n| clip | | fails "
      "after | error until then | zero action fails after | force |\n"
      "|---|---|---|---|---|---|\n",
      rows);
  return text;
}

std::string ReproduceChapter(const CardFacts& facts) {
  const v1::BundleManifest& manifest = facts.bundle.manifest;
  const std::string trained =
      !facts.command.empty()
          ? facts.command
          : absl::StrCat("./sinew train --recipe ", facts.run.recipe,
                         " --character ", manifest.character(),
                         " --motions LIB --run RUN --seed ", facts.run.seed,
                         SourceFlags(manifest.provenance()));
  std::string text = absl::StrCat(kReproduce, "\n\n    ", trained, "\n");
  if (facts.evaluation.is_object()) {
    absl::StrAppend(&text,
                    "    ./sinew eval --bundle RUN/bundle --motions LIB "
                    "--starts ",
                    NumberAt(facts.evaluation, {"starts_per_clip"}),
                    " --seconds ", NumberAt(facts.evaluation, {"seconds"}));
    if (facts.evaluation.contains("fallen")) {
      absl::StrAppend(&text, " --fallen ",
                      NumberAt(facts.evaluation, {"fallen", "starts"}));
    }
    absl::StrAppend(&text, " --out eval.json\n");
  }
  absl::StrAppend(
      &text,
      "\nLIB holds the clips above (`sinew motion import`). The same build on "
      "the same class of processor gives the same bits after as many "
      "iterations; others are as good.\n");
  return text;
}

std::string LoadChapter(const CardFacts& facts) {
  return absl::StrCat(
      kLoad,
      "\n\nIn C (deploy/runtime/sinew_runtime.h): reference "
      "and body in, joint targets out.\n\n"
      "```c\n"
      "char error[200];\n"
      "sinew_runtime* policy = sinew_open(\"bundle\", error, sizeof error);\n"
      "if (policy == NULL) return puts(error);\n"
      "sinew_load_library(policy, \"LIB\");\n"
      "sinew_play(policy, \"",
      facts.library.clips_size() > 0 ? facts.library.clips(0).name() : "CLIP",
      "\", 0.0, SINEW_ALIGN_TO_BODY);\n"
      "sinew_reset(policy, &state, NULL);\n"
      "sinew_step(policy, &state, target);  /* ",
      facts.bundle.manifest.control_hz(),
      " times a second */\n"
      "```\n",
      LatentSnippet(facts.bundle.manifest),
      "\nIn Python, the network alone (onnxruntime, numpy):\n\n",
      PythonSnippet(facts));
}

}  // namespace sinew::zoo
