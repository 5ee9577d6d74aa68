#include "sim/world/observation.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "sim/world/body_goal.h"
#include "sim/world/observation_writer.h"

namespace sinew::world {
namespace {

using v1::Observation;

using Writer = ObservationWriter;

void WriteSelf(const BodyState& body, const Eigen::Quaterniond& heading,
               Writer& out) {
  const Eigen::Matrix3d to_heading = heading.conjugate().toRotationMatrix();
  out.Scalar(body.position[0].z());
  out.Rotation(heading.conjugate() * body.rotation[0]);
  out.Vector(to_heading * body.linear_velocity[0]);
  out.Vector(to_heading * body.angular_velocity[0]);
  for (double position : body.joint_position) out.Scalar(position);
  for (double velocity : body.joint_velocity) out.Scalar(velocity);
  for (size_t b = 1; b < body.position.size(); ++b) {
    out.Vector(to_heading * (body.position[b] - body.position[0]));
  }
}

void WriteSelfBodies(const BodyState& body, const Eigen::Quaterniond& heading,
                     Writer& out) {
  const Eigen::Quaterniond inverse = heading.conjugate();
  const Eigen::Matrix3d to_heading = inverse.toRotationMatrix();
  out.Scalar(body.position[0].z());
  for (size_t b = 1; b < body.position.size(); ++b) {
    out.Vector(to_heading * (body.position[b] - body.position[0]));
  }
  for (const Eigen::Quaterniond& rotation : body.rotation) {
    out.Rotation(inverse * rotation);
  }
  for (const Eigen::Vector3d& velocity : body.linear_velocity) {
    out.Vector(to_heading * velocity);
  }
  for (const Eigen::Vector3d& velocity : body.angular_velocity) {
    out.Vector(to_heading * velocity);
  }
}

void WriteDifference(const BodyState& body, const BodyState& reference,
                     const Eigen::Quaterniond& heading, Writer& out) {
  const Eigen::Quaterniond inverse = heading.conjugate();
  const Eigen::Matrix3d to_heading = inverse.toRotationMatrix();
  const Eigen::Quaterniond turn =
      reference.rotation[0] * body.rotation[0].conjugate();
  out.Vector(to_heading * (reference.position[0] - body.position[0]));
  out.Rotation(inverse * turn * heading);
  out.Vector(to_heading *
             (reference.linear_velocity[0] - body.linear_velocity[0]));
  out.Vector(to_heading *
             (reference.angular_velocity[0] - body.angular_velocity[0]));
  for (size_t j = 0; j < body.joint_position.size(); ++j) {
    out.Scalar(reference.joint_position[j] - body.joint_position[j]);
  }
  for (size_t j = 0; j < body.joint_velocity.size(); ++j) {
    out.Scalar(reference.joint_velocity[j] - body.joint_velocity[j]);
  }
  for (size_t b = 1; b < body.position.size(); ++b) {
    out.Vector(to_heading * ((reference.position[b] - reference.position[0]) -
                             (body.position[b] - body.position[0])));
  }
}

void WriteBlock(Observation::Block block, const ObservationInput& input,
                const Eigen::Quaterniond& heading, Writer& out) {
  const BodyState& body = *input.body;
  switch (block) {
    case Observation::BLOCK_SELF_JOINT_SPACE:
      WriteSelf(body, heading, out);
      break;
    case Observation::BLOCK_REFERENCE_DIFFERENCE:
      for (const BodyState& reference : input.reference) {
        WriteDifference(body, reference, heading, out);
      }
      break;
    case Observation::BLOCK_PREVIOUS_TARGET:
      for (size_t j = 0; j < body.joint_position.size(); ++j) {
        out.Scalar(input.previous_target[j] - body.joint_position[j]);
      }
      break;
    case Observation::BLOCK_REFERENCE_CONTACT:
      for (const float* contact : input.reference_contact) {
        for (size_t f = 0; f < input.self_contact.size(); ++f) {
          out.Scalar(contact[f]);
        }
      }
      break;
    case Observation::BLOCK_SELF_CONTACT:
      for (float contact : input.self_contact) out.Scalar(contact);
      break;
    case Observation::BLOCK_REFERENCE_KEYPOINTS:
      for (const BodyState& reference : input.reference) {
        WriteKeypointGoal(body, reference, heading, out);
      }
      break;
    case Observation::BLOCK_REFERENCE_BODIES:
      for (const BodyState& reference : input.reference) {
        WriteBodyGoal(body, reference, heading, out);
      }
      break;
    case Observation::BLOCK_SELF_BODIES:
      WriteSelfBodies(body, heading, out);
      break;
    default:
      SINEW_CHECK(false) << "unknown observation block " << block;
  }
}

absl::Status CheckRecipe(const Observation& recipe) {
  for (int i = 0; i < recipe.blocks_size(); ++i) {
    const auto block = recipe.blocks(i);
    if (block == Observation::BLOCK_UNSPECIFIED ||
        !Observation::Block_IsValid(block)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "recipe field task.observation.blocks[", i,
          "]: expected a known block, found ", static_cast<int>(block)));
    }
    if (std::find(recipe.blocks().begin(), recipe.blocks().begin() + i,
                  block) != recipe.blocks().begin() + i) {
      return absl::InvalidArgumentError(
          absl::StrCat("recipe field task.observation.blocks[", i,
                       "]: expected each block once, found ",
                       Observation::Block_Name(block), " again"));
    }
  }
  for (int i = 0; i < recipe.frames_ahead_size(); ++i) {
    if (recipe.frames_ahead(i) < 1) {
      return absl::InvalidArgumentError(
          absl::StrCat("recipe field task.observation.frames_ahead[", i,
                       "]: expected >= 1, found ", recipe.frames_ahead(i)));
    }
  }
  return absl::OkStatus();
}

// "a/x", "a/y", "a/z".
void AddAxes(const std::string& prefix, std::vector<std::string>& names) {
  for (const char* axis : Writer::kVectorNames) {
    names.push_back(absl::StrCat(prefix, "/", axis));
  }
}

void AddSixD(const std::string& prefix, std::vector<std::string>& names) {
  for (const char* entry : Writer::kRotationNames) {
    names.push_back(absl::StrCat(prefix, "/", entry));
  }
}

// Columns that self and difference blocks share, from the root's rotation on.
void AddPoseNames(const std::string& prefix, const ObservationNames& names,
                  std::vector<std::string>& out) {
  AddSixD(prefix + "/root_rotation", out);
  AddAxes(prefix + "/root_linear_velocity", out);
  AddAxes(prefix + "/root_angular_velocity", out);
  for (const std::string& joint : names.joints) {
    out.push_back(absl::StrCat(prefix, "/joint_position/", joint));
  }
  for (const std::string& joint : names.joints) {
    out.push_back(absl::StrCat(prefix, "/joint_velocity/", joint));
  }
  for (size_t b = 1; b < names.bodies.size(); ++b) {
    AddAxes(absl::StrCat(prefix, "/body_position/", names.bodies[b]), out);
  }
}

// Another prefix than SELF_JOINT_SPACE, so that names differ where both are.
void AddSelfBodiesNames(const std::vector<std::string>& bodies,
                        std::vector<std::string>& out) {
  const std::string prefix = "self_body";
  out.push_back(prefix + "/root_height");
  for (size_t b = 1; b < bodies.size(); ++b) {
    AddAxes(absl::StrCat(prefix, "/position/", bodies[b]), out);
  }
  for (const std::string& body : bodies) {
    AddSixD(absl::StrCat(prefix, "/rotation/", body), out);
  }
  for (const char* quantity : {"linear_velocity", "angular_velocity"}) {
    for (const std::string& body : bodies) {
      AddAxes(absl::StrCat(prefix, "/", quantity, "/", body), out);
    }
  }
}

}  // namespace

absl::StatusOr<ObservationBuilder> ObservationBuilder::Create(
    const Observation& recipe, int bodies, int joints, int feet) {
  if (absl::Status status = CheckRecipe(recipe); !status.ok()) return status;
  ObservationBuilder builder;
  builder.bodies_ = bodies;
  builder.joints_ = joints;
  builder.feet_ = feet;
  for (int block : recipe.blocks()) {
    builder.blocks_.push_back(static_cast<Observation::Block>(block));
  }
  if (builder.blocks_.empty()) {
    builder.blocks_ = {Observation::BLOCK_SELF_JOINT_SPACE,
                       Observation::BLOCK_REFERENCE_DIFFERENCE};
  }
  builder.frames_ahead_.assign(recipe.frames_ahead().begin(),
                               recipe.frames_ahead().end());
  if (builder.frames_ahead_.empty()) builder.frames_ahead_ = {1};
  bool own = true;  // so far
  for (Observation::Block block : builder.blocks_) {
    own = own && IsSelfBlock(block);
    builder.width_ += builder.BlockWidth(block);
    if (own) builder.self_width_ = builder.width_;
  }
  return builder;
}

ObservationBuilder ObservationBuilder::SelfPart() const {
  ObservationBuilder part = *this;
  part.blocks_.erase(
      std::find_if_not(part.blocks_.begin(), part.blocks_.end(), IsSelfBlock),
      part.blocks_.end());
  part.width_ = self_width_;
  return part;
}

bool ObservationBuilder::Has(Observation::Block block) const {
  return std::find(blocks_.begin(), blocks_.end(), block) != blocks_.end();
}

int ObservationBuilder::BlockWidth(Observation::Block block) const {
  const int frames = static_cast<int>(frames_ahead_.size());
  const int pose = 12 + 2 * joints_ + 3 * (bodies_ - 1);
  switch (block) {
    case Observation::BLOCK_SELF_JOINT_SPACE:
      return 1 + pose;
    case Observation::BLOCK_REFERENCE_DIFFERENCE:
      return frames * (3 + pose);
    case Observation::BLOCK_PREVIOUS_TARGET:
      return joints_;
    case Observation::BLOCK_REFERENCE_CONTACT:
      return frames * feet_;
    case Observation::BLOCK_SELF_CONTACT:
      return feet_;
    case Observation::BLOCK_REFERENCE_KEYPOINTS:
      return frames * kKeypointWidth * bodies_;
    case Observation::BLOCK_REFERENCE_BODIES:
      return frames * kBodyGoalWidth * bodies_;
    case Observation::BLOCK_SELF_BODIES:
      return 15 * bodies_ - 2;
    default:
      SINEW_CHECK(false) << "unknown observation block " << block;
      return 0;
  }
}

std::optional<std::vector<int32_t>> ObservationBuilder::ColumnsOf(
    const ObservationBuilder& part) const {
  // Names tell columns apart; here any will do for joints and bodies.
  const auto numbered = [](int count) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.push_back(absl::StrCat(i));
    return names;
  };
  const auto names = [&](const ObservationBuilder& builder) {
    return builder.Names({.joints = numbered(builder.joints_),
                          .bodies = numbered(builder.bodies_),
                          .feet = numbered(builder.feet_)});
  };
  std::map<std::string, int32_t> place;
  int32_t column = 0;
  // Of a frame that is there twice, the first.
  for (std::string& name : names(*this)) {
    place.emplace(std::move(name), column++);
  }
  std::vector<int32_t> columns;
  for (const std::string& name : names(part)) {
    const auto found = place.find(name);
    if (found == place.end()) return std::nullopt;
    columns.push_back(found->second);
  }
  return columns;
}

void ObservationBuilder::Build(const ObservationInput& input,
                               absl::Span<float> out) const {
  SINEW_DCHECK(static_cast<int>(out.size()) == width_);
  const Eigen::Quaterniond heading = Heading(input.body->rotation[0]);
  Writer writer(out.data());
  for (Observation::Block block : blocks_) {
    WriteBlock(block, input, heading, writer);
  }
  SINEW_DCHECK(writer.position() == out.data() + out.size());
}

std::vector<std::string> ObservationBuilder::Names(
    const ObservationNames& names) const {
  std::vector<std::string> out;
  for (Observation::Block block : blocks_) {
    if (block == Observation::BLOCK_SELF_JOINT_SPACE) {
      out.push_back("self/root_height");
      AddPoseNames("self", names, out);
    } else if (block == Observation::BLOCK_PREVIOUS_TARGET) {
      for (const std::string& joint : names.joints) {
        out.push_back("previous_target/" + joint);
      }
    } else if (block == Observation::BLOCK_SELF_CONTACT) {
      for (const std::string& foot : names.feet) {
        out.push_back("self/contact/" + foot);
      }
    } else if (block == Observation::BLOCK_SELF_BODIES) {
      AddSelfBodiesNames(names.bodies, out);
    }
    for (int ahead : frames_ahead_) {
      const std::string prefix = absl::StrCat("reference+", ahead);
      if (block == Observation::BLOCK_REFERENCE_DIFFERENCE) {
        AddAxes(prefix + "/root_position", out);
        AddPoseNames(prefix, names, out);
      } else if (block == Observation::BLOCK_REFERENCE_CONTACT) {
        for (const std::string& foot : names.feet) {
          out.push_back(prefix + "/contact/" + foot);
        }
      } else if (block == Observation::BLOCK_REFERENCE_KEYPOINTS) {
        AddKeypointGoalNames(ahead, names.bodies, &out);
      } else if (block == Observation::BLOCK_REFERENCE_BODIES) {
        AddBodyGoalNames(ahead, names.bodies, &out);
      }
    }
  }
  return out;
}

}  // namespace sinew::world
