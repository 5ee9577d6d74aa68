#include "sim/import/formats/mjcf_joints.h"

#include <map>
#include <set>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::import {
namespace {

using tinyxml2::XMLElement;

// tinyxml2 bounds the depth of what it parses, and so of our recursion.

constexpr char kHinge[] = "hinge";  // the type of a joint that says none

std::string Attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

bool Is(const XMLElement& element, absl::string_view name) {
  return element.Name() == name;
}

// Elements that stand for bodies of another file, or for many.
bool StandsForOthers(const XMLElement& element) {
  for (const char* name :
       {"include", "attach", "replicate", "composite", "flexcomp"}) {
    if (Is(element, name)) return true;
  }
  return false;
}

class Reader {
 public:
  explicit Reader(absl::string_view source) : source_(source) {}

  absl::StatusOr<MjcfJoints> Read(const XMLElement& mujoco) {
    types_[""] = kHinge;
    for (const XMLElement* section = mujoco.FirstChildElement();
         section != nullptr; section = section->NextSiblingElement()) {
      if (Is(*section, "default")) ReadDefaults(*section, kHinge, true);
    }
    for (const XMLElement* section = mujoco.FirstChildElement();
         section != nullptr; section = section->NextSiblingElement()) {
      if (StandsForOthers(*section)) {
        return Error("a model in one file", *section);
      }
      if (Is(*section, "worldbody")) {
        SINEW_RETURN_IF_ERROR(ReadBodies(*section, ""));
      }
    }
    return joints_;
  }

 private:
  absl::Status Error(absl::string_view expected, const XMLElement& found) {
    return absl::InvalidArgumentError(absl::StrCat(
        source_, ": line ", found.GetLineNum(), ": expected ", expected,
        ", found <", found.Name(), " name=\"", Attribute(found, "name"),
        "\" type=\"", Attribute(found, "type"), "\">"));
  }

  // Joint types by class; nested classes inherit.
  void ReadDefaults(const XMLElement& section, std::string type, bool is_main) {
    if (const XMLElement* joint = section.FirstChildElement("joint")) {
      if (joint->Attribute("type")) type = Attribute(*joint, "type");
    }
    types_[Attribute(section, "class")] = type;
    if (is_main) types_[""] = type;
    for (const XMLElement* nested = section.FirstChildElement("default");
         nested != nullptr; nested = nested->NextSiblingElement("default")) {
      ReadDefaults(*nested, type, /*is_main=*/false);
    }
  }

  std::string TypeOf(const XMLElement& joint, const std::string& child_class) {
    if (joint.Attribute("type")) return Attribute(joint, "type");
    const char* own = joint.Attribute("class");
    const auto type = types_.find(own == nullptr ? child_class : own);
    return type == types_.end() ? types_[""] : type->second;
  }

  absl::Status AddJoint(const XMLElement& joint, const std::string& type) {
    if (type == "free") {
      if (!joints_.empty()) {
        return Error("one free joint, before all others", joint);
      }
      joints_.has_free_joint = true;
      return absl::OkStatus();
    }
    if (type != kHinge) return Error("a free joint and hinges", joint);
    const std::string name = Attribute(joint, "name");
    if (name.empty() || !names_.insert(name).second) {
      return Error("hinges with names, each once", joint);
    }
    joints_.hinges.push_back(name);
    return absl::OkStatus();
  }

  // The joints of a body, also those inside frames.
  absl::Status ReadJoints(const XMLElement& body,
                          const std::string& child_class) {
    for (const XMLElement* element = body.FirstChildElement();
         element != nullptr; element = element->NextSiblingElement()) {
      if (StandsForOthers(*element)) {
        return Error("a model in one file", *element);
      }
      if (Is(*element, "freejoint")) {
        SINEW_RETURN_IF_ERROR(AddJoint(*element, "free"));
      } else if (Is(*element, "joint")) {
        SINEW_RETURN_IF_ERROR(
            AddJoint(*element, TypeOf(*element, child_class)));
      } else if (Is(*element, "frame")) {
        SINEW_RETURN_IF_ERROR(
            ReadJoints(*element, ChildClass(*element, child_class)));
      }
    }
    return absl::OkStatus();
  }

  // The bodies below the world or a body, also those inside frames; each with
  // its joints before those of the bodies below it.
  absl::Status ReadBodies(const XMLElement& parent,
                          const std::string& child_class) {
    for (const XMLElement* element = parent.FirstChildElement();
         element != nullptr; element = element->NextSiblingElement()) {
      const std::string own_class = ChildClass(*element, child_class);
      if (StandsForOthers(*element)) {
        return Error("a model in one file", *element);
      }
      if (Is(*element, "frame")) {
        SINEW_RETURN_IF_ERROR(ReadBodies(*element, own_class));
      }
      if (!Is(*element, "body")) continue;
      if (Attribute(*element, "mocap") == "true") {
        joints_.mocap_bodies.push_back(Attribute(*element, "name"));
      }
      SINEW_RETURN_IF_ERROR(ReadJoints(*element, own_class));
      SINEW_RETURN_IF_ERROR(ReadBodies(*element, own_class));
    }
    return absl::OkStatus();
  }

  static std::string ChildClass(const XMLElement& element,
                                const std::string& inherited) {
    const char* own = element.Attribute("childclass");
    return own == nullptr ? inherited : own;
  }

  const absl::string_view source_;
  std::map<std::string, std::string> types_;  // by default class
  std::set<std::string> names_;
  MjcfJoints joints_;
};

}  // namespace

absl::StatusOr<MjcfJoints> ReadMjcfJoints(const XMLElement& mujoco,
                                          absl::string_view source) {
  return Reader(source).Read(mujoco);
}

}  // namespace sinew::import
