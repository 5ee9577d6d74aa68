#include "common/rpc/testing/socket_folder.h"

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/files.h"

namespace sinew::rpc {

SocketFolder::SocketFolder() : path_("/tmp/sinew-XXXXXX") {
  SINEW_CHECK(mkdtemp(path_.data()) != nullptr) << path_;
}

SocketFolder::~SocketFolder() { RemoveRecursively(path_).IgnoreError(); }

std::string SocketFolder::Address(const std::string& name) const {
  return absl::StrCat("unix:", path_, "/", name);
}

}  // namespace sinew::rpc
