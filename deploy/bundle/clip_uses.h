#ifndef SINEW_DEPLOY_BUNDLE_CLIP_USES_H_
#define SINEW_DEPLOY_BUNDLE_CLIP_USES_H_

#include <map>
#include <set>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"

namespace sinew::bundle {

// What clips were to the training of a bundle: BundleProvenance.clip_uses.
//
// Thread-safety: pure functions. Ownership: none. Blocking: never. Errors:
// none.

// By name of the clip.
using ClipUses = std::map<std::string, v1::ClipUse>;

// A clip's entry in BundleProvenance.clips: "NAME: ORIGIN (LICENCE)".
std::string ClipEntryOf(const v1::ClipInfo& clip);

// The clip's name in an entry; part of `clip`.
absl::string_view ClipNameOf(absl::string_view clip);

// What a bundle says; empty where it does not, as bundles of old versions.
ClipUses ClipUsesOf(const v1::BundleProvenance& provenance);

// What the clips of a library and of the bundles that a run was made from are
// to what the run comes to. A name that several of them have gets what is the
// most: trained on, by a source, unknown, left out.
ClipUses ClipUsesOfRun(const v1::Start& start, const v1::MotionLibrary& library,
                       absl::Span<const v1::RunInputs::Source> sources);

// The names of those that the bundle's own training drew starts from.
std::set<std::string> TrainedOn(const ClipUses& uses);

// "trained on", "trained on by a source", "unknown" or "left out".
absl::string_view WordsOf(v1::ClipUse use);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_CLIP_USES_H_
