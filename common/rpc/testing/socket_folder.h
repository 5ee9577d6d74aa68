#ifndef SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_
#define SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_

#include <memory>
#include <string>

#include "common/temporary_folder.h"

namespace sinew::rpc {

// A new folder under /tmp for unix sockets, whose paths must be short (a
// test's own folder is not); removed with all it holds at the end.
class SocketFolder {
 public:
  // Aborts with a message on failure.
  SocketFolder();

  // "unix:FOLDER/NAME".
  std::string Address(const std::string& name) const;
  const std::string& path() const { return folder_->path(); }

 private:
  std::unique_ptr<const TemporaryFolder> folder_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_
