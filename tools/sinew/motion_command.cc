#include "tools/sinew/motion_command.h"

#include "tools/sinew/motion_blend.h"
#include "tools/sinew/motion_import.h"
#include "tools/sinew/motion_inspect.h"
#include "tools/sinew/motion_map.h"
#include "tools/sinew/motion_render.h"
#include "tools/sinew/motion_report.h"

namespace sinew::tools {

void AddMotionCommand(CLI::App& app, Action& action) {
  auto* motion = app.add_subcommand("motion", "motion libraries");
  motion->require_subcommand(1);
  AddMotionImport(*motion, action);
  AddMotionBlend(*motion, action);
  AddMotionInspect(*motion, action);
  AddMotionMap(*motion, action);
  AddMotionRender(*motion, action);
  AddMotionReport(*motion, action);
}

}  // namespace sinew::tools
