#include "deploy/bundle/run_export.h"

#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/config/text_proto.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/content.h"
#include "google/protobuf/text_format.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/character/character_files.h"

namespace sinew::bundle {
namespace {

constexpr int kInputsVersion = 1;

std::string InputsFolder(const std::string& run) {
  return JoinPath(run, "inputs");
}
std::string InputsFile(const std::string& run) {
  return JoinPath(InputsFolder(run), "inputs.textproto");
}
std::string CharacterFolder(const std::string& run) {
  return JoinPath(InputsFolder(run), "character");
}

absl::StatusOr<v1::Recipe> ReadRecipe(const std::string& run) {
  const std::string path = JoinPath(run, "config.textproto");
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe recipe, ParseRecipe(text, path));
  recipe = WithDefaults(std::move(recipe));
  SINEW_RETURN_IF_ERROR(ValidateRecipe(recipe));
  return recipe;
}

absl::StatusOr<std::unique_ptr<character::Character>> LoadCharacter(
    const std::string& run, const v1::Physics& physics,
    const v1::RunInputs& inputs) {
  const std::string path =
      JoinPath(CharacterFolder(run), "character.textproto");
  SINEW_ASSIGN_OR_RETURN(auto character,
                         character::Character::Load(path, physics));
  if (character->digest() != inputs.character_sha256()) {
    return absl::DataLossError(absl::StrCat(
        path, ": expected a character of digest ", inputs.character_sha256(),
        ", found ", character->digest(), ": altered since the run started"));
  }
  return character;
}

absl::Status WriteCharacter(const std::map<std::string, std::string>& files,
                            const std::string& folder) {
  SINEW_RETURN_IF_ERROR(RemoveRecursively(folder));
  for (const auto& [name, content] : files) {
    const std::string path = JoinPath(folder, name);
    SINEW_RETURN_IF_ERROR(
        MakeDirectories(std::filesystem::path(path).parent_path().string()));
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, content));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status SaveRunInputs(const std::string& run, const std::string& character,
                           const motion::Library& library,
                           absl::Span<const v1::RunInputs::Source> sources,
                           const std::string& assets_sha256) {
  SINEW_ASSIGN_OR_RETURN(const auto files,
                         character::CharacterFiles(character));
  SINEW_RETURN_IF_ERROR(RemoveRecursively(InputsFile(run)));
  SINEW_RETURN_IF_ERROR(WriteCharacter(files, CharacterFolder(run)));
  v1::RunInputs inputs;
  inputs.set_format_version(kInputsVersion);
  inputs.set_character_sha256(library.manifest().character_sha256());
  *inputs.mutable_library() = library.manifest();
  inputs.set_library_sha256(library.digest());
  inputs.mutable_sources()->Add(sources.begin(), sources.end());
  inputs.set_assets_sha256(assets_sha256);
  // What is written now is what an export will find.
  SINEW_RETURN_IF_ERROR(LoadCharacter(run, v1::Physics(), inputs).status());
  std::string text;
  google::protobuf::TextFormat::PrintToString(inputs, &text);
  return WriteFileAtomically(InputsFile(run), text);
}

absl::StatusOr<v1::RunInputs> ReadRunInputs(const std::string& run) {
  const std::string path = InputsFile(run);
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  v1::RunInputs inputs;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, path, inputs));
  if (inputs.format_version() != kInputsVersion) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": format_version: expected ", kInputsVersion,
                     ", found ", inputs.format_version()));
  }
  return inputs;
}

v1::RunInputs::Source MakeSource(absl::string_view role,
                                 const std::string& manifest_sha256,
                                 const v1::BundleProvenance& provenance) {
  v1::RunInputs::Source source;
  source.mutable_bundle()->set_role(std::string(role));
  source.mutable_bundle()->set_recipe(provenance.recipe());
  source.mutable_bundle()->set_manifest_sha256(manifest_sha256);
  *source.mutable_clips() = provenance.clips();
  *source.mutable_data_licences() = provenance.data_licences();
  *source.mutable_clip_uses() = provenance.clip_uses();
  return source;
}

v1::RunInputs::Source MakeSource(absl::string_view role,
                                 const v1::BundleManifest& manifest) {
  return MakeSource(role, manifest.manifest_sha256(), manifest.provenance());
}

absl::Status ExportRun(const std::string& run, const RunResult& result,
                       const std::string& directory) {
  SINEW_ASSIGN_OR_RETURN(const v1::Recipe recipe, ReadRecipe(run));
  SINEW_ASSIGN_OR_RETURN(const v1::RunInputs inputs, ReadRunInputs(run));
  SINEW_ASSIGN_OR_RETURN(const auto character,
                         LoadCharacter(run, recipe.physics(), inputs));
  ContentInputs content;
  content.recipe = recipe;
  content.character = character.get();
  SINEW_ASSIGN_OR_RETURN(content.character_files,
                         character::CharacterFiles(JoinPath(
                             CharacterFolder(run), "character.textproto")));
  content.library = inputs.library();
  content.library_sha256 = inputs.library_sha256();
  content.sources.assign(inputs.sources().begin(), inputs.sources().end());
  content.snapshot = result.snapshot;
  content.iterations = result.iterations;
  content.samples = result.samples;
  content.train_seconds = result.train_seconds;
  content.build = result.build;
  SINEW_ASSIGN_OR_RETURN(BundleContent made, MakeContent(content));
  if (result.metrics) *made.manifest.mutable_metrics() = *result.metrics;
  return WriteBundle(made, directory);
}

}  // namespace sinew::bundle
