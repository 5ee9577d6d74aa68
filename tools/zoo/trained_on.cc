#include "tools/zoo/trained_on.h"

#include <map>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/clip_uses.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "tools/evaluation/figures_table.h"
#include "tools/zoo/card_chapters.h"

namespace sinew::zoo {
namespace {

using evaluation::TableCell;

// Names by credit and licence.
using Credits = std::map<std::string, std::vector<std::string>>;

// What clips may have been to training, in the order of the card.
constexpr v1::ClipUse kUses[] = {v1::CLIP_USE_TRAINED_ON,
                                 v1::CLIP_USE_SOURCE_TRAINED_ON,
                                 v1::CLIP_USE_UNKNOWN, v1::CLIP_USE_LEFT_OUT};

// What the bundle says; of one that does not, as of an old version, what the
// library leaves out where it is the one that was trained on.
bundle::ClipUses UsesOf(const CardFacts& facts) {
  const v1::BundleProvenance& provenance = facts.bundle.manifest.provenance();
  bundle::ClipUses uses = bundle::ClipUsesOf(provenance);
  if (!uses.empty() || facts.library_sha256 != provenance.library_sha256()) {
    return uses;
  }
  for (const v1::ClipInfo& clip : facts.library.clips()) {
    if (clip.left_out()) uses[clip.name()] = v1::CLIP_USE_LEFT_OUT;
  }
  return uses;
}

// Clips, "NAME: ORIGIN (LICENCE)" as bundles have them, by their uses; trained
// on where nothing else is said.
std::map<v1::ClipUse, Credits> CreditsByUse(const CardFacts& facts) {
  const bundle::ClipUses uses = UsesOf(facts);
  std::map<v1::ClipUse, Credits> credits;
  for (const std::string& clip : facts.bundle.manifest.provenance().clips()) {
    const std::string name(bundle::ClipNameOf(clip));
    const std::string credit(name.size() == clip.size()
                                 ? bundle::kUnknown
                                 : clip.substr(name.size() + 2));
    const auto use = uses.find(name);
    credits[use == uses.end() ? v1::CLIP_USE_TRAINED_ON : use->second][credit]
        .push_back(name);
  }
  return credits;
}

int Count(const Credits& credits) {
  size_t count = 0;
  for (const auto& [credit, names] : credits) count += names.size();
  return static_cast<int>(count);
}

void AddRows(const Credits& credits, absl::string_view kind,
             std::string* text) {
  for (const auto& [credit, names] : credits) {
    absl::StrAppend(text, "| ", names.size(), " | ", kind, " | ",
                    TableCell(credit), " |\n");
  }
}

std::string Names(const Credits& credits) {
  std::vector<std::string> all;
  for (const auto& [credit, names] : credits) {
    all.insert(all.end(), names.begin(), names.end());
  }
  return TableCell(absl::StrJoin(all, ", "));
}

// What is not known of the clips of the bundles that it was made from.
std::string Caveat(const v1::BundleProvenance& provenance) {
  if (provenance.sources_size() == 0) return "";
  const bundle::ClipUses uses = bundle::ClipUsesOf(provenance);
  if (uses.empty()) {
    return "\nWhich clips were left out when the bundles that it was made from "
           "(see Training) were trained is not known here: they may have seen "
           "clips that are left out above.\n";
  }
  for (const auto& [name, use] : uses) {
    if (use != v1::CLIP_USE_UNKNOWN) continue;
    return "\nUnknown: a bundle that it was made from (see Training) may have "
           "seen these clips; it does not say which were left out when it was "
           "trained.\n";
  }
  return "";
}

}  // namespace

std::string TrainedOnChapter(const CardFacts& facts) {
  const v1::BundleProvenance& provenance = facts.bundle.manifest.provenance();
  std::map<v1::ClipUse, Credits> credits = CreditsByUse(facts);
  std::string text = absl::StrCat(
      kTrainedOn, "\n\nClips: ", Count(credits[v1::CLIP_USE_TRAINED_ON]),
      ", and ", Count(credits[v1::CLIP_USE_LEFT_OUT]),
      " left out of training. Library ", provenance.library_sha256(),
      ".\n\n| clips | | credit and licence |\n|---|---|---|\n");
  for (const v1::ClipUse use : kUses) {
    AddRows(credits[use], bundle::WordsOf(use), &text);
  }
  absl::StrAppend(&text, Caveat(provenance),
                  "\nLicences of clips and character:\n\n");
  for (const std::string& licence : provenance.data_licences()) {
    absl::StrAppend(&text, "- ", licence, "\n");
  }
  absl::StrAppend(&text, "\n<details><summary>Names</summary>\n");
  for (const v1::ClipUse use : kUses) {
    if (credits[use].empty()) continue;
    std::string words(bundle::WordsOf(use));
    words[0] = absl::ascii_toupper(words[0]);
    absl::StrAppend(&text, "\n", words, ": ", Names(credits[use]), ".\n");
  }
  absl::StrAppend(&text, "\n</details>\n");
  return text;
}

}  // namespace sinew::zoo
