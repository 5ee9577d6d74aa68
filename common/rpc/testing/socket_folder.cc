#include "common/rpc/testing/socket_folder.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"

namespace sinew::rpc {

SocketFolder::SocketFolder() {
  auto folder = TemporaryFolder::Create();
  SINEW_CHECK(folder.ok()) << folder.status().ToString();
  folder_ = *std::move(folder);
}

std::string SocketFolder::Address(const std::string& name) const {
  return absl::StrCat("unix:", path(), "/", name);
}

}  // namespace sinew::rpc
