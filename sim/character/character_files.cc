#include "sim/character/character_files.h"

#include <mujoco/mujoco.h>
#include <tinyxml2.h>

#include <filesystem>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
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
    const bool unneeded_mesh = Is(*element, "mesh") &&
                               element->Attribute("file") != nullptr &&
                               !needed.contains(MeshName(*element));
    if (unneeded_geom || unneeded_mesh || Is(*element, "texture")) {
      element->Parent()->DeleteChild(element);
    } else if (Is(*element, "material")) {
      element->DeleteAttribute("texture");
    }
  });
}

bool HasIncludes(XMLElement* root) {
  bool found = false;
  Walk(root, [&found](XMLElement* element) {
    found = found || Is(*element, "include");
  });
  return found;
}

// Folders in which MuJoCo looks for assets, relative to the model's.
struct AssetFolders {
  std::string mesh, texture;
};

void ReadFolders(XMLElement* root, AssetFolders* folders) {
  Walk(root, [folders](XMLElement* element) {
    if (!Is(*element, "compiler")) return;
    const std::string asset = Attribute(*element, "assetdir");
    const std::string mesh = Attribute(*element, "meshdir");
    const std::string texture = Attribute(*element, "texturedir");
    if (!asset.empty()) *folders = {.mesh = asset, .texture = asset};
    if (!mesh.empty()) folders->mesh = mesh;
    if (!texture.empty()) folders->texture = texture;
  });
}

// Files that a document names, relative to the model's folder.
std::set<std::string> NamedFiles(XMLElement* root,
                                 const AssetFolders& folders) {
  std::set<std::string> names;
  Walk(root, [&](XMLElement* element) {
    Path folder = folders.mesh;
    if (Is(*element, "include")) folder = "";
    if (Is(*element, "texture")) folder = folders.texture;
    for (const tinyxml2::XMLAttribute* attribute = element->FirstAttribute();
         attribute != nullptr; attribute = attribute->Next()) {
      if (absl::StartsWith(attribute->Name(), "file")) {
        names.insert((folder / attribute->Value()).lexically_normal());
      }
    }
  });
  return names;
}

absl::Status Parse(const std::string& path, const std::string& text,
                   tinyxml2::XMLDocument* document) {
  if (document->Parse(text.data(), text.size()) == tinyxml2::XML_SUCCESS) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": expected XML, found: ", document->ErrorStr()));
}

// A model's files while they are gathered.
struct Gathering {
  Path folder;       // where the model lies
  Path name_folder;  // where it is to lie, below the character's folder
  AssetFolders assets;
  std::map<std::string, std::string>* files;
};

// Adds what the document names, and what that names.
absl::Status AddNamed(const std::string& path, XMLElement* root,
                      Gathering& gathering) {
  ReadFolders(root, &gathering.assets);
  for (const std::string& name : NamedFiles(root, gathering.assets)) {
    if (Path(name).is_absolute() || absl::StartsWith(name, "..")) {
      return absl::InvalidArgumentError(absl::StrCat(
          path, ": expected files in its own folder, found ", name));
    }
    const std::string to = (gathering.name_folder / name).string();
    if (gathering.files->contains(to)) continue;
    const std::string from = (gathering.folder / name).string();
    SINEW_ASSIGN_OR_RETURN(const std::string content, ReadFile(from));
    (*gathering.files)[to] = content;
    if (!absl::EndsWith(name, ".xml")) continue;
    tinyxml2::XMLDocument included;
    SINEW_RETURN_IF_ERROR(Parse(from, content, &included));
    SINEW_RETURN_IF_ERROR(AddNamed(from, included.RootElement(), gathering));
  }
  return absl::OkStatus();
}

absl::Status AddModel(const std::string& path, const std::string& name,
                      const mjModel& model,
                      std::map<std::string, std::string>& files) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  tinyxml2::XMLDocument document;
  SINEW_RETURN_IF_ERROR(Parse(path, text, &document));
  XMLElement* root = document.RootElement();
  files[name] = text;
  if (!HasIncludes(root) && !NamedFiles(root, AssetFolders()).empty()) {
    StripVisuals(NeededMeshes(model), root);
    tinyxml2::XMLPrinter printer;
    document.Print(&printer);
    files[name] = printer.CStr();
  }
  Gathering gathering = {.folder = Path(path).parent_path(),
                         .name_folder = Path(name).parent_path(),
                         .assets = {},
                         .files = &files};
  return AddNamed(path, root, gathering);
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
  SINEW_RETURN_IF_ERROR(
      AddModel(model_path, LocalModelFile(proto.model_file()), *model, files));
  return files;
}

}  // namespace sinew::character
