#include "sim/world/body_goal.h"

#include "absl/strings/str_cat.h"

namespace sinew::world {
namespace {

// "PREFIX/QUANTITY/BODY/ENTRY" for each entry.
template <size_t kCount>
void AddEntries(const std::string& prefix, const char* quantity,
                const std::string& body, const char* const (&entries)[kCount],
                std::vector<std::string>* names) {
  for (const char* entry : entries) {
    names->push_back(
        absl::StrCat(prefix, "/", quantity, "/", body, "/", entry));
  }
}

constexpr auto& kAxes = ObservationWriter::kVectorNames;
constexpr auto& kSixD = ObservationWriter::kRotationNames;

}  // namespace

void WriteKeypointGoal(const BodyState& body, const BodyState& reference,
                       const Eigen::Quaterniond& heading,
                       ObservationWriter& out) {
  const Eigen::Matrix3d to_heading = heading.conjugate().toRotationMatrix();
  for (size_t b = 0; b < body.position.size(); ++b) {
    out.Vector(to_heading * (reference.position[b] - body.position[b]));
    out.Vector(to_heading *
               (reference.linear_velocity[b] - body.linear_velocity[b]));
    out.Vector(to_heading * (reference.position[b] - body.position[0]));
  }
}

void WriteBodyGoal(const BodyState& body, const BodyState& reference,
                   const Eigen::Quaterniond& heading, ObservationWriter& out) {
  const Eigen::Quaterniond inverse = heading.conjugate();
  const Eigen::Matrix3d to_heading = inverse.toRotationMatrix();
  for (size_t b = 0; b < body.position.size(); ++b) {
    const Eigen::Quaterniond turn =
        reference.rotation[b] * body.rotation[b].conjugate();
    out.Vector(to_heading * (reference.position[b] - body.position[b]));
    out.Rotation(inverse * turn * heading);
    out.Vector(to_heading *
               (reference.linear_velocity[b] - body.linear_velocity[b]));
    out.Vector(to_heading *
               (reference.angular_velocity[b] - body.angular_velocity[b]));
    out.Vector(to_heading * (reference.position[b] - body.position[0]));
    out.Rotation(inverse * reference.rotation[b]);
  }
}

void AddKeypointGoalNames(int ahead, const std::vector<std::string>& bodies,
                          std::vector<std::string>* names) {
  const std::string prefix = absl::StrCat("keypoint+", ahead);
  for (const std::string& body : bodies) {
    AddEntries(prefix, "position_difference", body, kAxes, names);
    AddEntries(prefix, "linear_velocity_difference", body, kAxes, names);
    AddEntries(prefix, "position", body, kAxes, names);
  }
}

void AddBodyGoalNames(int ahead, const std::vector<std::string>& bodies,
                      std::vector<std::string>* names) {
  const std::string prefix = absl::StrCat("body+", ahead);
  for (const std::string& body : bodies) {
    AddEntries(prefix, "position_difference", body, kAxes, names);
    AddEntries(prefix, "rotation_difference", body, kSixD, names);
    AddEntries(prefix, "linear_velocity_difference", body, kAxes, names);
    AddEntries(prefix, "angular_velocity_difference", body, kAxes, names);
    AddEntries(prefix, "position", body, kAxes, names);
    AddEntries(prefix, "rotation", body, kSixD, names);
  }
}

}  // namespace sinew::world
