#ifndef SINEW_TOOLS_SINEW_SECURITY_FLAGS_H_
#define SINEW_TOOLS_SINEW_SECURITY_FLAGS_H_

#include <CLI/CLI.hpp>

#include "common/rpc/credentials.h"

namespace sinew::tools {

// The flags by which a role says how it proves who it is; see rpc::Security,
// which also checks what was given. `security` outlives the parsing.
inline void AddSecurityFlags(CLI::App& command, rpc::Security& security) {
  command.add_option("--tls-certificate", security.certificate_file,
                     "PEM file: own certificate chain");
  command.add_option("--tls-key", security.key_file,
                     "PEM file: its private key");
  command.add_option("--tls-authority", security.authority_file,
                     "PEM file: who signs the peers' certificates");
  command.add_flag("--allow-insecure", security.allow_insecure,
                   "plain text to and from other machines");
}

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_SECURITY_FLAGS_H_
