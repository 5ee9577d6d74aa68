#ifndef SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_
#define SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_

#include <string>

namespace sinew::rpc {

// A new folder under /tmp for unix sockets, whose paths must be short (a
// test's own folder is not); removed with all it holds at the end.
class SocketFolder {
 public:
  SocketFolder();
  ~SocketFolder();
  SocketFolder(const SocketFolder&) = delete;
  SocketFolder& operator=(const SocketFolder&) = delete;

  // "unix:FOLDER/NAME".
  std::string Address(const std::string& name) const;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_TESTING_SOCKET_FOLDER_H_
