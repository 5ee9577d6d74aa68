#include "sim/character/mujoco_messages.h"

#include <mujoco/mujoco.h>

#include <mutex>

namespace sinew::character {
namespace {

thread_local WarningCollector* innermost = nullptr;
// What the process had before the first collector; null: MuJoCo's own.
void (*handler_before)(const char*) = nullptr;

}  // namespace

WarningCollector::WarningCollector() : outer_(innermost) {
  static std::once_flag installed;
  std::call_once(installed, [] {
    handler_before = mju_user_warning;
    mju_user_warning = &Collect;
  });
  innermost = this;
}

WarningCollector::~WarningCollector() { innermost = outer_; }

void WarningCollector::Collect(const char* message) {
  if (innermost == nullptr) {
    if (handler_before != nullptr) handler_before(message);
    return;
  }
  if (!innermost->text_.empty()) innermost->text_ += '\n';
  innermost->text_ += message;
}

}  // namespace sinew::character
