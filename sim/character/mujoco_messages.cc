#include "sim/character/mujoco_messages.h"

#include <mujoco/mujoco.h>

#include <mutex>

namespace sinew::character {
namespace {

thread_local WarningCollector* innermost = nullptr;

}  // namespace

WarningCollector::WarningCollector() : outer_(innermost) {
  static std::once_flag installed;
  std::call_once(installed, [] { mju_user_warning = &Collect; });
  innermost = this;
}

WarningCollector::~WarningCollector() { innermost = outer_; }

void WarningCollector::Collect(const char* message) {
  if (innermost == nullptr) return;
  if (!innermost->text_.empty()) innermost->text_ += '\n';
  innermost->text_ += message;
}

}  // namespace sinew::character
