#include "tools/render/gl_context.h"

#include <GL/osmesa.h>
#include <dlfcn.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"

namespace sinew::render {
namespace {

constexpr char kLibrary[] = "libOSMesa.so.8";
constexpr char kPackage[] = "libosmesa6";
// The default framebuffer; pictures go into one of their own.
constexpr int kWindowSize = 16;
constexpr int kDepthBits = 24;
constexpr int kStencilBits = 8;

}  // namespace

struct GlContext::Library {
  decltype(&OSMesaCreateContextExt) create = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaDestroyContext) destroy = nullptr;
  std::string error;

  // The one library of the process; never unloaded.
  static const Library& Get();
};

const GlContext::Library& GlContext::Library::Get() {
  static const Library& library = *[] {
    auto* loaded = new Library;
    // Global: MuJoCo looks for OSMesaGetProcAddress among the symbols of the
    // process.
    void* handle = dlopen(kLibrary, RTLD_NOW | RTLD_GLOBAL);
    if (handle == nullptr) {
      loaded->error = dlerror();
      return loaded;
    }
    loaded->create = reinterpret_cast<decltype(loaded->create)>(
        dlsym(handle, "OSMesaCreateContextExt"));
    loaded->make_current = reinterpret_cast<decltype(loaded->make_current)>(
        dlsym(handle, "OSMesaMakeCurrent"));
    loaded->destroy = reinterpret_cast<decltype(loaded->destroy)>(
        dlsym(handle, "OSMesaDestroyContext"));
    if (!loaded->create || !loaded->make_current || !loaded->destroy) {
      loaded->error = "it lacks OSMesa's functions";
    }
    // Where several GL libraries are loaded, MuJoCo is told which to ask.
    setenv("MUJOCO_GL", "osmesa", /*overwrite=*/1);
    return loaded;
  }();
  return library;
}

absl::StatusOr<std::unique_ptr<GlContext>> GlContext::Create() {
  const Library& library = Library::Get();
  if (!library.error.empty()) {
    return absl::UnavailableError(absl::StrCat("rendering: expected ", kLibrary,
                                               " (Debian package ", kPackage,
                                               "), found: ", library.error));
  }
  void* context = library.create(OSMESA_RGBA, kDepthBits, kStencilBits,
                                 /*accumBits=*/0, /*sharelist=*/nullptr);
  if (context == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("rendering: ", kLibrary, " made no context"));
  }
  return std::unique_ptr<GlContext>(new GlContext(library, context));
}

GlContext::GlContext(const Library& library, void* context)
    : library_(library),
      context_(context),
      window_(size_t{4} * kWindowSize * kWindowSize) {}

GlContext::~GlContext() {
  library_.destroy(static_cast<OSMesaContext>(context_));
}

absl::Status GlContext::MakeCurrent() {
  if (library_.make_current(static_cast<OSMesaContext>(context_),
                            window_.data(), GL_UNSIGNED_BYTE, kWindowSize,
                            kWindowSize) == GL_FALSE) {
    return absl::InternalError("rendering: could not bind the GL context");
  }
  return absl::OkStatus();
}

}  // namespace sinew::render
