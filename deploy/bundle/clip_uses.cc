#include "deploy/bundle/clip_uses.h"

#include "absl/strings/str_cat.h"
#include "deploy/bundle/bundle.h"
#include "sim/world/start.h"

namespace sinew::bundle {
namespace {

// What goes before what where a name has several uses.
int Rank(v1::ClipUse use) {
  switch (use) {
    case v1::CLIP_USE_TRAINED_ON:
      return 3;
    case v1::CLIP_USE_SOURCE_TRAINED_ON:
      return 2;
    case v1::CLIP_USE_LEFT_OUT:
      return 0;
    default:
      return 1;
  }
}

void Add(absl::string_view name, v1::ClipUse use, ClipUses* uses) {
  const auto [at, added] = uses->emplace(name, use);
  if (!added && Rank(use) > Rank(at->second)) at->second = use;
}

void AddSource(const v1::RunInputs::Source& source, ClipUses* uses) {
  const bool says = source.clip_uses_size() == source.clips_size();
  for (int i = 0; i < source.clips_size(); ++i) {
    v1::ClipUse use = v1::CLIP_USE_UNKNOWN;
    if (says) use = source.clip_uses(i);
    if (use == v1::CLIP_USE_TRAINED_ON) use = v1::CLIP_USE_SOURCE_TRAINED_ON;
    Add(ClipNameOf(source.clips(i)), use, uses);
  }
}

}  // namespace

std::string ClipEntryOf(const v1::ClipInfo& clip) {
  return absl::StrCat(clip.name(), ": ", OrUnknown(clip.provenance()), " (",
                      OrUnknown(clip.licence()), ")");
}

absl::string_view ClipNameOf(absl::string_view clip) {
  return clip.substr(0, clip.find(": "));
}

ClipUses ClipUsesOf(const v1::BundleProvenance& provenance) {
  ClipUses uses;
  if (provenance.clip_uses_size() != provenance.clips_size()) return uses;
  for (int i = 0; i < provenance.clips_size(); ++i) {
    Add(ClipNameOf(provenance.clips(i)), provenance.clip_uses(i), &uses);
  }
  return uses;
}

ClipUses ClipUsesOfRun(const v1::Start& start, const v1::MotionLibrary& library,
                       absl::Span<const v1::RunInputs::Source> sources) {
  ClipUses uses;
  for (const v1::ClipInfo& clip : library.clips()) {
    // As entries will be read.
    Add(ClipNameOf(clip.name()),
        world::IsDrawn(start, clip) ? v1::CLIP_USE_TRAINED_ON
                                    : v1::CLIP_USE_LEFT_OUT,
        &uses);
  }
  for (const v1::RunInputs::Source& source : sources) AddSource(source, &uses);
  for (const v1::RunInputs::Source& source : sources) {
    if (source.clips_size() > 0) continue;
    // Runs of older versions know a teacher elsewhere by its digest alone: it
    // may have seen any clip.
    for (auto& [name, use] : uses) {
      if (use == v1::CLIP_USE_LEFT_OUT) use = v1::CLIP_USE_UNKNOWN;
    }
  }
  return uses;
}

std::set<std::string> TrainedOn(const ClipUses& uses) {
  std::set<std::string> names;
  for (const auto& [name, use] : uses) {
    if (use == v1::CLIP_USE_TRAINED_ON) names.insert(name);
  }
  return names;
}

absl::string_view WordsOf(v1::ClipUse use) {
  switch (use) {
    case v1::CLIP_USE_TRAINED_ON:
      return "trained on";
    case v1::CLIP_USE_SOURCE_TRAINED_ON:
      return "trained on by a source";
    case v1::CLIP_USE_LEFT_OUT:
      return "left out";
    default:
      return "unknown";
  }
}

}  // namespace sinew::bundle
