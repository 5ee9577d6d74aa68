#ifndef SINEW_TOOLS_REPORT_INERT_JSON_H_
#define SINEW_TOOLS_REPORT_INERT_JSON_H_

#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_replace.h"

namespace sinew::report {

// JSON that may stand inside <script>: the same values, but in ASCII and
// without characters that HTML or old JavaScript would see. `Json` is any
// nlohmann::basic_json. Pure.
template <typename Json>
std::string InertJson(const Json& data) {
  const std::string text =
      data.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace);
  return absl::StrReplaceAll(
      text, {{"<", "\\u003c"}, {">", "\\u003e"}, {"&", "\\u0026"}});
}

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_INERT_JSON_H_
