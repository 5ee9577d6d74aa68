#include "sim/character/scenery.h"

#include <algorithm>
#include <array>

namespace sinew::character {
namespace {

using Colour = std::array<double, 3>;

constexpr Colour kZenith = {0.93, 0.95, 0.98};
constexpr Colour kHorizon = {0.99, 0.99, 0.99};
constexpr Colour kTile = {0.96, 0.97, 0.98};
constexpr Colour kOtherTile = {0.88, 0.90, 0.92};
// One pattern of two by two tiles is two metres wide.
constexpr float kRepeatsPerMetre = 0.5f;
constexpr int kTexturePixels = 64;
// Width of the map of shadows: software draws all of it for each picture.
constexpr int kShadowPixels = 1024;

template <typename T>
void Set(const Colour& colour, T* rgb) {
  std::copy(colour.begin(), colour.end(), rgb);
}

void AddSky(mjSpec* spec) {
  mjsTexture* sky = mjs_addTexture(spec, nullptr);
  mjs_setName(sky->element, "sinew_sky");
  sky->type = mjTEXTURE_SKYBOX;
  sky->builtin = mjBUILTIN_GRADIENT;
  sky->width = kTexturePixels;
  sky->height = kTexturePixels * 6;
  Set(kZenith, sky->rgb1);
  Set(kHorizon, sky->rgb2);
}

void AddFloorMaterial(mjSpec* spec) {
  mjsTexture* tiles = mjs_addTexture(spec, nullptr);
  mjs_setName(tiles->element, "sinew_tiles");
  tiles->type = mjTEXTURE_2D;
  tiles->builtin = mjBUILTIN_CHECKER;
  tiles->width = kTexturePixels;
  tiles->height = kTexturePixels;
  Set(kTile, tiles->rgb1);
  Set(kOtherTile, tiles->rgb2);

  mjsMaterial* floor = mjs_addMaterial(spec, nullptr);
  mjs_setName(floor->element, "sinew_floor");
  mjs_setInStringVec(floor->textures, mjTEXROLE_RGB, "sinew_tiles");
  floor->texuniform = 1;
  floor->texrepeat[0] = floor->texrepeat[1] = kRepeatsPerMetre;
  floor->reflectance = 0;
}

void AddLamp(mjsBody* world) {
  mjsLight* lamp = mjs_addLight(world, nullptr);
  mjs_setName(lamp->element, "sinew_lamp");
  lamp->type = mjLIGHT_DIRECTIONAL;
  lamp->castshadow = 1;
  const double position[3] = {0, 0, 4};
  const double direction[3] = {-0.35, 0.3, -1};
  std::copy(position, position + 3, lamp->pos);
  std::copy(direction, direction + 3, lamp->dir);
  for (int i = 0; i < 3; ++i) {
    lamp->ambient[i] = 0;
    lamp->diffuse[i] = 0.55f;
    lamp->specular[i] = 0.1f;
  }
}

}  // namespace

void AddScenery(mjSpec* spec) {
  AddSky(spec);
  AddFloorMaterial(spec);
  mjsBody* world = mjs_findBody(spec, "world");
  for (mjsElement* element = mjs_firstChild(world, mjOBJ_GEOM, 0);
       element != nullptr; element = mjs_nextChild(world, element, 0)) {
    mjsGeom* geom = mjs_asGeom(element);
    if (geom->type != mjGEOM_PLANE) continue;
    mjs_setString(geom->material, "sinew_floor");
    // Not the colour that the model's defaults give to limbs.
    std::fill(geom->rgba, geom->rgba + 4, 1.0f);
    // A floor in its own shadow map speckles.
    geom->castshadow = 0;
    break;
  }
  AddLamp(world);
  spec->visual.quality.shadowsize = kShadowPixels;
  for (int i = 0; i < 3; ++i) {
    spec->visual.headlight.ambient[i] = 0.45f;
    spec->visual.headlight.diffuse[i] = 0.2f;
    spec->visual.headlight.specular[i] = 0;
  }
}

}  // namespace sinew::character
