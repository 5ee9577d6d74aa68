#ifndef SINEW_TOOLS_RENDER_GL_CONTEXT_H_
#define SINEW_TOOLS_RENDER_GL_CONTEXT_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sinew::render {

// An OpenGL context without window or GPU: Mesa's off-screen library, loaded
// when the first context is made, so that programs which render nothing do not
// carry it.
//
// Thread-safety: one thread at a time; MakeCurrent binds the context to the
// calling thread. Ownership: owns the context; destroy it on the thread that
// used it last. Blocking: Create loads a library. Errors: UNAVAILABLE naming
// the library, what it said, and the Debian package that has it.
class GlContext {
 public:
  static absl::StatusOr<std::unique_ptr<GlContext>> Create();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Binds the context to this thread.
  absl::Status MakeCurrent();

 private:
  struct Library;
  GlContext(const Library& library, void* context);

  const Library& library_;
  void* context_;
  std::vector<uint8_t> window_;  // pixels that nobody looks at
};

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_GL_CONTEXT_H_
