#include "sim/character/character.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/text_proto.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "google/protobuf/text_format.h"
#include "sim/character/character_path.h"
#include "sim/character/model_builder.h"
#include "sim/character/model_digest.h"

namespace sinew::character {
namespace {

constexpr int kFormatVersion = 1;

absl::Status Invalid(absl::string_view source, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("character ", source, ": ", what));
}

std::string NameOf(const mjModel& model, mjtObj type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name == nullptr ? absl::StrCat("#", id) : name;
}

absl::Status CheckPositive(absl::string_view source, absl::string_view field,
                           double value) {
  if (value > 0 && std::isfinite(value)) return absl::OkStatus();
  return Invalid(source,
                 absl::StrCat(field, ": expected > 0, found ", value));
}

absl::Status CheckHeader(const v1::Character& proto, absl::string_view source) {
  if (proto.format_version() != kFormatVersion) {
    return Invalid(source, absl::StrCat("format_version: expected ",
                                        kFormatVersion, ", found ",
                                        proto.format_version()));
  }
  if (proto.name().empty() ||
      proto.name().find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") !=
          std::string::npos) {
    return Invalid(source, absl::StrCat("name: expected [a-z0-9_]+, found \"",
                                        proto.name(), "\""));
  }
  if (proto.feet_size() == 0) {
    return Invalid(source, "feet: expected at least one, found none");
  }
  if (proto.actuator_law().derivation().empty()) {
    return Invalid(source,
                   "actuator_law.derivation: expected a sentence, found none");
  }
  return CheckPositive(source, "standing_root_height",
                       proto.standing_root_height());
}

}  // namespace

absl::StatusOr<std::unique_ptr<Character>> Character::Load(
    const std::string& name_or_path, const v1::Physics& physics) {
  SINEW_ASSIGN_OR_RETURN(const std::string path, FindCharacter(name_or_path));
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(path, /*max_bytes=*/1 << 20));
  auto result = std::unique_ptr<Character>(new Character());
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, path, result->proto_));
  SINEW_RETURN_IF_ERROR(CheckHeader(result->proto_, path));
  SINEW_ASSIGN_OR_RETURN(const std::string model_path,
                         FindModelFile(path, result->proto_.model_file()));
  SINEW_ASSIGN_OR_RETURN(result->model_,
                         BuildModel(model_path, result->proto_, physics));
  SINEW_RETURN_IF_ERROR(result->Resolve(path));
  return result;
}

absl::StatusOr<std::unique_ptr<Character>> Character::FromAssets(
    absl::string_view character_text, absl::string_view model_binary,
    absl::string_view source) {
  auto result = std::unique_ptr<Character>(new Character());
  SINEW_RETURN_IF_ERROR(
      ParseTextProto(character_text, source, result->proto_));
  SINEW_RETURN_IF_ERROR(CheckHeader(result->proto_, source));
  result->model_.reset(mj_loadModelBuffer(
      model_binary.data(), static_cast<mjtSize>(model_binary.size())));
  if (result->model_ == nullptr) {
    return Invalid(source, absl::StrCat("model: expected a binary model of "
                                        "MuJoCo ",
                                        mj_versionString(), ", found ",
                                        model_binary.size(),
                                        " bytes that it cannot read"));
  }
  SINEW_RETURN_IF_ERROR(result->Resolve(source));
  return result;
}

absl::Status Character::ResolveJoints(absl::string_view source) {
  const mjModel& model = *model_;
  std::set<int> hinges;
  int free_joints = 0;
  for (int id = 0; id < model.njnt; ++id) {
    if (model.jnt_type[id] == mjJNT_FREE) {
      ++free_joints;
    } else if (model.jnt_type[id] == mjJNT_HINGE) {
      hinges.insert(id);
    } else {
      return Invalid(source, absl::StrCat("joint ", NameOf(model, mjOBJ_JOINT, id),
                                          ": expected a hinge or the root's "
                                          "free joint"));
    }
  }
  if (free_joints != 1 || model.nbody < 2 || model.body_jntnum[1] != 1 ||
      model.jnt_type[model.body_jntadr[1]] != mjJNT_FREE) {
    return Invalid(source, absl::StrCat("expected one free joint, on the first "
                                        "body, found ",
                                        free_joints));
  }
  for (const v1::Joint& joint : proto_.joints()) {
    const int id = mj_name2id(&model, mjOBJ_JOINT, joint.name().c_str());
    if (id < 0) {
      return Invalid(source, absl::StrCat("joints: no joint \"", joint.name(),
                                          "\" in the model"));
    }
    if (hinges.erase(id) == 0) {
      return Invalid(source, absl::StrCat("joints: \"", joint.name(),
                                          "\" is no hinge or named twice"));
    }
    const std::string field = absl::StrCat("joint ", joint.name());
    SINEW_RETURN_IF_ERROR(
        CheckPositive(source, field + " stiffness", joint.stiffness()));
    SINEW_RETURN_IF_ERROR(
        CheckPositive(source, field + " torque_limit", joint.torque_limit()));
    if (!(joint.damping() >= 0) || !std::isfinite(joint.damping())) {
      return Invalid(source, absl::StrCat(field, " damping: expected >= 0, found ",
                                          joint.damping()));
    }
    const bool limited = model.jnt_limited[id] != 0;
    const double infinity = std::numeric_limits<double>::infinity();
    joints_.push_back({
        .name = joint.name(),
        .joint_id = id,
        .qpos_address = model.jnt_qposadr[id],
        .dof_address = model.jnt_dofadr[id],
        .stiffness = joint.stiffness(),
        .damping = joint.damping(),
        .torque_limit = joint.torque_limit(),
        .lower = limited ? model.jnt_range[2 * id] : -infinity,
        .upper = limited ? model.jnt_range[2 * id + 1] : infinity,
        .default_position = joint.default_position(),
        .action_scale = joint.action_scale(),
    });
  }
  if (!hinges.empty()) {
    return Invalid(source, absl::StrCat("joints: hinge \"",
                                        NameOf(model, mjOBJ_JOINT, *hinges.begin()),
                                        "\" of the model is missing"));
  }
  return absl::OkStatus();
}

absl::StatusOr<int> Character::BodyId(absl::string_view source,
                                      absl::string_view field,
                                      const std::string& name) const {
  const int id = mj_name2id(model_.get(), mjOBJ_BODY, name.c_str());
  if (id > 0) return id;
  return Invalid(source, absl::StrCat(field, ": no body \"", name,
                                      "\" in the model"));
}

absl::Status Character::ResolveTracked(absl::string_view source) {
  std::map<int, int> place;  // model body id -> index into tracked_
  if (proto_.tracked_bodies_size() == 0) {
    for (int id = 1; id < model_->nbody; ++id) tracked_.push_back(id - 1);
  }
  for (const std::string& name : proto_.tracked_bodies()) {
    SINEW_ASSIGN_OR_RETURN(const int id, BodyId(source, "tracked_bodies", name));
    tracked_.push_back(id - 1);
  }
  if (tracked_.front() != 0) {
    return Invalid(source, "tracked_bodies: expected the root first");
  }
  for (size_t i = 0; i < tracked_.size(); ++i) {
    if (!place.emplace(tracked_[i] + 1, static_cast<int>(i)).second) {
      return Invalid(source, absl::StrCat(
                                 "tracked_bodies: \"",
                                 NameOf(*model_, mjOBJ_BODY, tracked_[i] + 1),
                                 "\" is named twice"));
    }
  }
  std::set<int> exempt(foot_bodies_.begin(), foot_bodies_.end());
  if (proto_.termination_exempt_bodies_size() > 0) {
    exempt.clear();
    for (const std::string& name : proto_.termination_exempt_bodies()) {
      SINEW_ASSIGN_OR_RETURN(const int id,
                             BodyId(source, "termination_exempt_bodies", name));
      if (!place.contains(id)) {
        return Invalid(source, absl::StrCat("termination_exempt_bodies: \"",
                                            name, "\" is not tracked"));
      }
      exempt.insert(id);
    }
  }
  for (size_t i = 0; i < tracked_.size(); ++i) {
    if (!exempt.contains(tracked_[i] + 1)) {
      terminating_.push_back(static_cast<int>(i));
    }
  }
  return absl::OkStatus();
}

absl::Status Character::ResolveFeet(absl::string_view source) {
  for (const v1::Foot& foot : proto_.feet()) {
    SINEW_ASSIGN_OR_RETURN(const int body, BodyId(source, "feet", foot.body()));
    std::vector<int> geoms;
    if (foot.geoms_size() == 0) {
      for (int i = 0; i < model_->body_geomnum[body]; ++i) {
        const int geom = model_->body_geomadr[body] + i;
        if (model_->geom_conaffinity[geom] != 0) geoms.push_back(geom);
      }
    }
    for (const std::string& name : foot.geoms()) {
      const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, name.c_str());
      if (geom < 0 || model_->geom_bodyid[geom] != body) {
        return Invalid(source, absl::StrCat("feet: no geom \"", name,
                                            "\" on body \"", foot.body(), "\""));
      }
      geoms.push_back(geom);
    }
    if (geoms.empty()) {
      return Invalid(source, absl::StrCat("feet: body \"", foot.body(),
                                          "\" has no geom that touches"));
    }
    foot_bodies_.push_back(body);
    foot_geoms_.push_back(std::move(geoms));
  }
  return absl::OkStatus();
}

absl::Status Character::Resolve(absl::string_view source) {
  SINEW_RETURN_IF_ERROR(ResolveJoints(source));
  SINEW_RETURN_IF_ERROR(ResolveFeet(source));
  SINEW_RETURN_IF_ERROR(ResolveTracked(source));
  SINEW_ASSIGN_OR_RETURN(head_body_,
                         BodyId(source, "head_body", proto_.head_body()));
  floor_geom_ = -1;
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (model_->geom_bodyid[geom] == 0 &&
        model_->geom_type[geom] == mjGEOM_PLANE) {
      floor_geom_ = geom;
    }
  }
  if (floor_geom_ < 0) return Invalid(source, "model: expected a floor plane");
  total_mass_ = model_->body_subtreemass[0];
  digest_ = BodyDigest(*model_, floor_geom_, character_text());
  return absl::OkStatus();
}

std::string Character::model_binary() const {
  std::string bytes(mj_sizeModel(model_.get()), '\0');
  mj_saveModel(model_.get(), nullptr, bytes.data(),
               static_cast<mjtSize>(bytes.size()));
  return bytes;
}

std::string Character::character_text() const {
  std::string text;
  google::protobuf::TextFormat::PrintToString(proto_, &text);
  return text;
}

}  // namespace sinew::character
