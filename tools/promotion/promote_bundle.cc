#include "tools/promotion/promote_bundle.h"

#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "deploy/checkpoint/folder_files.h"
#include "deploy/checkpoint/stable_bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tools/evaluation/bundle_subject.h"

namespace sinew::tools {
namespace {

constexpr size_t kDigits = 16;

struct Evaluated {
  v1::BundleManifest manifest;
  SetSummary figures;
};

// A bundle's files, evaluated in a folder of their own.
absl::StatusOr<Evaluated> EvaluateFiles(const checkpoint::ArtifactFiles& files,
                                        const PromotionOptions& options,
                                        const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TemporaryFolder> scratch,
                         TemporaryFolder::Create());
  const std::string folder = JoinPath(scratch->path(), "bundle");
  SINEW_RETURN_IF_ERROR(checkpoint::WriteFolder(files, folder));
  SINEW_ASSIGN_OR_RETURN(
      evaluation::BundleSubject loaded,
      evaluation::LoadBundleSubject(folder, options.motions));
  SINEW_ASSIGN_OR_RETURN(
      EvaluationSummary summary,
      evaluation::EvaluatePolicy(loaded.subject, options.evaluation, stop));
  return Evaluated{.manifest = std::move(loaded.manifest),
                   .figures = std::move(summary.overall)};
}

// The same status with what it is about in front.
absl::Status About(const std::string& what, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(),
                      absl::StrCat(what, ": ", status.message()));
}

absl::Status EvaluateIncumbent(const PromotionOptions& options,
                               checkpoint::ArtifactStore& store,
                               const StopToken& stop, Promotion& result) {
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         GetFiles(store, result.incumbent_id));
  auto incumbent = EvaluateFiles(files, options, stop);
  SINEW_RETURN_IF_ERROR(About(absl::StrCat("incumbent ", result.incumbent_id),
                              incumbent.status()));
  result.incumbent = std::move(incumbent->figures);
  return absl::OkStatus();
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
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         checkpoint::ReadFolder(options.bundle));
  Promotion result;
  SINEW_ASSIGN_OR_RETURN(result.incumbent_id, checkpoint::StableBundle(store));
  auto candidate = EvaluateFiles(files, options, stop);
  SINEW_RETURN_IF_ERROR(About(options.bundle, candidate.status()));
  result.candidate = std::move(candidate->figures);
  result.id = options.id;
  if (result.id.empty()) {
    const absl::string_view digest = candidate->manifest.manifest_sha256();
    result.id = absl::StrCat("bundle-", digest.substr(0, kDigits));
  }
  if (!result.incumbent_id.empty()) {
    SINEW_RETURN_IF_ERROR(EvaluateIncumbent(options, store, stop, result));
  }
  result.verdict =
      JudgePromotion(result.candidate, result.incumbent, options.rule);
  if (!result.verdict.promoted) return result;
  SINEW_RETURN_IF_ERROR(Store(files, candidate->manifest, result, store));
  return result;
}

}  // namespace sinew::tools
