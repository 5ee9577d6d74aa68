#include "tools/sinew/role_logger.h"

#include <memory>
#include <utility>

#include "common/clock.h"
#include "common/logging.h"
#include "common/status_macros.h"

namespace sinew::tools {

absl::Status LogAs(const std::string& role) {
  static const SystemClock& clock = *new SystemClock();  // as long as the log
  Logger::Options options;
  options.role = role;
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<Logger> logger,
                         Logger::Create(options, clock));
  SetProgramLogger(std::move(logger));
  return absl::OkStatus();
}

}  // namespace sinew::tools
