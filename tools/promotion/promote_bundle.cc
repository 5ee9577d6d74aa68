#include "tools/promotion/promote_bundle.h"

#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "deploy/bundle/bundle.h"
#include "deploy/checkpoint/folder_files.h"
#include "deploy/checkpoint/stable_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/promotion/succession.h"

namespace sinew::tools {
namespace {

constexpr size_t kDigits = 16;

// A bundle's files, read from a folder of their own; the distance as
// LoadBundleSubject has it.
absl::StatusOr<evaluation::BundleSubject> Load(
    const std::string& what, const checkpoint::ArtifactFiles& files,
    const PromotionOptions& options,
    std::optional<double> max_mean_body_distance = std::nullopt) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TemporaryFolder> scratch,
                         TemporaryFolder::Create());
  const std::string folder = JoinPath(scratch->path(), "bundle");
  SINEW_RETURN_IF_ERROR(checkpoint::WriteFolder(files, folder));
  auto loaded = evaluation::LoadBundleSubject(
      folder, options.motions, /*fallen_starts=*/0, max_mean_body_distance);
  SINEW_RETURN_IF_ERROR(WithContext(loaded.status(), what));
  return loaded;
}

absl::StatusOr<EvaluationSummary> Evaluate(
    const std::string& what, const evaluation::BundleSubject& bundle,
    const PromotionOptions& options, const StopToken& stop) {
  auto summary =
      evaluation::EvaluatePolicy(bundle.subject, options.evaluation, stop);
  SINEW_RETURN_IF_ERROR(WithContext(summary.status(), what));
  return summary;
}

// The incumbent, which the candidate can stand for; starts of both fail at the
// same distance.
absl::StatusOr<evaluation::BundleSubject> LoadIncumbent(
    const std::string& what, const Promotion& promotion,
    const v1::BundleManifest& candidate, const PromotionOptions& options,
    checkpoint::ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         GetFiles(store, promotion.incumbent_id));
  SINEW_ASSIGN_OR_RETURN(
      evaluation::BundleSubject incumbent,
      Load(
          what, files, options,
          bundle::TaskRecipe(candidate).evaluation().max_mean_body_distance()));
  SINEW_RETURN_IF_ERROR(
      WithContext(CheckSuccession(incumbent.manifest, candidate),
                  absl::StrCat(options.bundle, ": cannot follow ", what)));
  return incumbent;
}

absl::Status Store(const checkpoint::ArtifactFiles& files,
                   const v1::BundleManifest& manifest, const Promotion& made,
                   checkpoint::ArtifactStore& store) {
  v1::Artifact record;
  record.set_id(made.id);
  record.set_kind(checkpoint::kBundleKind);
  record.set_iteration(manifest.provenance().iterations());
  SINEW_RETURN_IF_ERROR(PutFiles(store, record, files));
  return checkpoint::MoveStable(store, made.id, made.incumbent_id);
}

}  // namespace

absl::StatusOr<Promotion> PromoteBundle(const PromotionOptions& options,
                                        checkpoint::ArtifactStore& store,
                                        const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(options.rule.Validate());
  if (!options.id.empty()) {
    SINEW_RETURN_IF_ERROR(
        WithContext(checkpoint::CheckArtifactId(options.id), "--id"));
  }
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         checkpoint::ReadFolder(options.bundle));
  Promotion result;
  SINEW_ASSIGN_OR_RETURN(result.incumbent_id, checkpoint::StableBundle(store));
  SINEW_ASSIGN_OR_RETURN(const evaluation::BundleSubject candidate,
                         Load(options.bundle, files, options));
  result.id = options.id;
  if (result.id.empty()) {
    const absl::string_view digest = candidate.manifest.manifest_sha256();
    result.id = absl::StrCat("bundle-", digest.substr(0, kDigits));
  }
  if (!result.incumbent_id.empty()) {
    const std::string what = absl::StrCat("incumbent ", result.incumbent_id);
    SINEW_ASSIGN_OR_RETURN(
        const evaluation::BundleSubject incumbent,
        LoadIncumbent(what, result, candidate.manifest, options, store));
    SINEW_ASSIGN_OR_RETURN(result.incumbent,
                           Evaluate(what, incumbent, options, stop));
  }
  SINEW_ASSIGN_OR_RETURN(result.candidate,
                         Evaluate(options.bundle, candidate, options, stop));
  result.verdict =
      JudgePromotion(result.candidate, result.incumbent, options.rule);
  if (!result.verdict.promoted) return result;
  SINEW_RETURN_IF_ERROR(Store(files, candidate.manifest, result, store));
  return result;
}

}  // namespace sinew::tools
