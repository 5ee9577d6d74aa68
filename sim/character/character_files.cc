#include "sim/character/character_files.h"

#include <mujoco/mujoco.h>
#include <tinyxml2.h>

#include <filesystem>
#include <set>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/character.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character_path.h"
#include "sim/character/character_text.h"
#include "sim/character/compile.h"

namespace sinew::character {
namespace {

using Path = std::filesystem::path;
using tinyxml2::XMLElement;

// Calls `visit` for every element below (and with) `element`, children first.
template <typename Visit>
void Walk(XMLElement* element, const Visit& visit) {
  for (XMLElement* child = element->FirstChildElement(); child != nullptr;) {
    XMLElement* next = child->NextSiblingElement();
    Walk(child, visit);
    child = next;
  }
  visit(element);
}

std::string Attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

bool Is(const XMLElement& element, absl::string_view name) {
  return element.Name() == name;
}

// MuJoCo's name of a mesh asset.
std::string MeshName(const XMLElement& mesh) {
  const std::string name = Attribute(mesh, "name");
  return name.empty() ? Path(Attribute(mesh, "file")).stem().string() : name;
}

// Names of the meshes that physics needs.
std::set<std::string> NeededMeshes(const mjModel& model) {
  std::set<std::string> names;
  for (int i = 0; i < model.nmesh; ++i) {
    names.insert(mj_id2name(&model, mjOBJ_MESH, i));
  }
  return names;
}

// Removes meshes that physics does not need, their geoms, and textures.
void StripVisuals(const std::set<std::string>& needed, XMLElement* root) {
  Walk(root, [&needed](XMLElement* element) {
    const std::string mesh = Attribute(*element, "mesh");
    const bool unneeded_geom =
        Is(*element, "geom") && !mesh.empty() && !needed.contains(mesh);
    const bool unneeded_mesh =
        Is(*element, "mesh") && element->Attribute("file") != nullptr &&
        !needed.contains(MeshName(*element));
    if (unneeded_geom || unneeded_mesh || Is(*element, "texture")) {
      element->Parent()->DeleteChild(element);
    } else if (Is(*element, "material")) {
      element->DeleteAttribute("texture");
    }
  });
}

// File names (no folders) that the document still asks for.
std::set<std::string> NamedFiles(XMLElement* root) {
  std::set<std::string> names;
  Walk(root, [&names](XMLElement* element) {
    for (const tinyxml2::XMLAttribute* attribute = element->FirstAttribute();
         attribute != nullptr; attribute = attribute->Next()) {
      if (absl::StartsWith(attribute->Name(), "file")) {
        names.insert(Path(attribute->Value()).filename().string());
      }
    }
  });
  return names;
}

bool HasIncludes(XMLElement* root) {
  bool found = false;
  Walk(root, [&found](XMLElement* element) {
    found = found || Is(*element, "include");
  });
  return found;
}

// Paths of the files that an MJCF names, those of included ones too.
std::vector<std::string> Dependencies(const std::string& model_path) {
  mjStringVec files;
  mju_getXMLDependencies(model_path.c_str(), &files);
  return files;
}

// Adds the MJCF's dependencies whose name is in `wanted` (all if it is null),
// in the places that they have beside it.
absl::Status AddDependencies(const std::string& model_path,
                             const std::string& model_name,
                             const std::set<std::string>* wanted,
                             std::map<std::string, std::string>& files) {
  const Path folder = std::filesystem::absolute(model_path).parent_path();
  const Path own = std::filesystem::absolute(model_path).lexically_normal();
  for (const std::string& file : Dependencies(model_path)) {
    const Path path = std::filesystem::absolute(file).lexically_normal();
    if (path == own) continue;
    if (wanted != nullptr && !wanted->contains(path.filename().string())) {
      continue;
    }
    const Path relative = path.lexically_relative(folder);
    if (relative.empty() || *relative.begin() == "..") {
      return absl::InvalidArgumentError(
          absl::StrCat(model_path, ": expected files in its own folder, found ",
                       path.string()));
    }
    const Path name = Path(model_name).parent_path() / relative;
    SINEW_ASSIGN_OR_RETURN(files[name.string()], ReadFile(path.string()));
  }
  return absl::OkStatus();
}

absl::Status AddModel(const std::string& path, const std::string& name,
                      const mjModel& model,
                      std::map<std::string, std::string>& files) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": expected XML, found: ", document.ErrorStr()));
  }
  XMLElement* root = document.RootElement();
  if (HasIncludes(root)) {
    files[name] = text;
    return AddDependencies(path, name, /*wanted=*/nullptr, files);
  }
  if (NamedFiles(root).empty()) {
    files[name] = text;
    return absl::OkStatus();
  }
  StripVisuals(NeededMeshes(model), root);
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  files[name] = printer.CStr();
  const std::set<std::string> wanted = NamedFiles(root);
  return AddDependencies(path, name, &wanted, files);
}

}  // namespace

absl::StatusOr<std::map<std::string, std::string>> CharacterFiles(
    const std::string& name_or_path) {
  SINEW_ASSIGN_OR_RETURN(const std::string path, FindCharacter(name_or_path));
  std::map<std::string, std::string> files;
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  SINEW_ASSIGN_OR_RETURN(const v1::Character proto, ParseCharacter(text, path));
  files["character.textproto"] = text;
  SINEW_ASSIGN_OR_RETURN(const std::string model_path,
                         FindModelFile(path, proto.model_file()));
  SINEW_ASSIGN_OR_RETURN(
      const ModelPtr model,
      CompileModel(model_path, proto, v1::Physics(), Purpose::kPhysics));
  std::string name = proto.model_file();
  if (absl::StartsWith(name, "@")) {
    name = absl::StrReplaceAll(name.substr(1), {{"//", "/"}});
  }
  SINEW_RETURN_IF_ERROR(AddModel(model_path, name, *model, files));
  return files;
}

}  // namespace sinew::character
