#include "sim/character/character.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/character/character_path.h"
#include "sim/character/character_text.h"
#include "sim/character/compile.h"
#include "sim/character/model_digest.h"
#include "sim/character/mujoco_messages.h"
#include "sim/character/resolve.h"

namespace sinew::character {
namespace {

// Text protos are a few kilobytes.
constexpr int64_t kMaxTextBytes = 1 << 20;

struct Source {
  std::string path;
  std::string model_path;
  v1::Character proto;
};

absl::StatusOr<Source> ReadSource(const std::string& name_or_path) {
  Source source;
  SINEW_ASSIGN_OR_RETURN(source.path, FindCharacter(name_or_path));
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(source.path, kMaxTextBytes));
  SINEW_ASSIGN_OR_RETURN(source.proto, ParseCharacter(text, source.path));
  SINEW_ASSIGN_OR_RETURN(source.model_path,
                         FindModelFile(source.path, source.proto.model_file()));
  return source;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Character>> Character::Load(
    const std::string& name_or_path, const v1::Physics& physics) {
  SINEW_ASSIGN_OR_RETURN(Source source, ReadSource(name_or_path));
  std::unique_ptr<Character> character(new Character);
  character->proto_ = std::move(source.proto);
  SINEW_ASSIGN_OR_RETURN(character->model_,
                         CompileModel(source.model_path, character->proto_,
                                      physics, Purpose::kPhysics));
  SINEW_RETURN_IF_ERROR(character->Resolve(source.path));
  return character;
}

absl::StatusOr<std::unique_ptr<Character>> Character::FromAssets(
    absl::string_view character_text, absl::string_view model_binary,
    absl::string_view source) {
  std::unique_ptr<Character> character(new Character);
  SINEW_ASSIGN_OR_RETURN(character->proto_,
                         ParseCharacter(character_text, source));
  const WarningCollector warnings;
  character->model_.reset(mj_loadModelBuffer(
      model_binary.data(), static_cast<mjtSize>(model_binary.size())));
  if (character->model_ == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        std::string(source), ": expected a compiled model of MuJoCo ",
        mj_versionString(), ", found ", model_binary.size(),
        " bytes that are none: ", warnings.text()));
  }
  SINEW_RETURN_IF_ERROR(character->Resolve(source));
  return character;
}

absl::StatusOr<ModelPtr> Character::CompileForPictures(
    const std::string& name_or_path) {
  SINEW_ASSIGN_OR_RETURN(const Source source, ReadSource(name_or_path));
  return CompileModel(source.model_path, source.proto, v1::Physics(),
                      Purpose::kPictures);
}

absl::Status Character::Resolve(absl::string_view source) {
  const Resolver resolver(proto_, *model_, source);
  SINEW_RETURN_IF_ERROR(resolver.CheckTree());
  SINEW_ASSIGN_OR_RETURN(joints_, resolver.Joints());
  SINEW_ASSIGN_OR_RETURN(tracked_, resolver.Tracked());
  SINEW_RETURN_IF_ERROR(resolver.Feet(&foot_bodies_, &foot_geoms_));
  SINEW_ASSIGN_OR_RETURN(terminating_,
                         resolver.Terminating(tracked_, foot_bodies_));
  SINEW_ASSIGN_OR_RETURN(head_body_, resolver.Head());
  SINEW_ASSIGN_OR_RETURN(floor_geom_, resolver.Floor());
  SINEW_RETURN_IF_ERROR(resolver.CheckMirrors());
  total_mass_ = mj_getTotalmass(model_.get());
  digest_ = ModelDigest(proto_, *model_);
  return absl::OkStatus();
}

std::string Character::model_binary() const {
  std::string binary(static_cast<size_t>(mj_sizeModel(model_.get())), '\0');
  mj_saveModel(model_.get(), nullptr, binary.data(),
               static_cast<mjtSize>(binary.size()));
  return binary;
}

std::string Character::character_text() const { return PrintCharacter(proto_); }

}  // namespace sinew::character
