#ifndef SINEW_SIM_CHARACTER_MUJOCO_MESSAGES_H_
#define SINEW_SIM_CHARACTER_MUJOCO_MESSAGES_H_

#include <string>

namespace sinew::character {

// Collects the warnings that MuJoCo raises on this thread while it lives.
//
// MuJoCo's own handler writes each warning to the terminal and to a file
// MUJOCO_LOG.TXT in the current folder. The first collector of the process
// replaces it for good: from then on warnings on threads without a collector
// go to the handler that the program had set by then, or are dropped where it
// had set none. Nothing is lost, since mjData counts the warnings of a
// simulation by kind, and no simulation writes to disk.
//
// Thread-safety: one thread per object; objects of one thread nest. Blocking:
// never. Errors: none.
class WarningCollector {
 public:
  WarningCollector();
  ~WarningCollector();
  WarningCollector(const WarningCollector&) = delete;
  WarningCollector& operator=(const WarningCollector&) = delete;

  // All so far, one per line; empty if none.
  const std::string& text() const { return text_; }

 private:
  static void Collect(const char* message);

  std::string text_;
  WarningCollector* outer_;
};

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_MUJOCO_MESSAGES_H_
