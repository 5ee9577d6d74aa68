#ifndef SINEW_COMMON_RPC_TESTING_CERTIFICATES_H_
#define SINEW_COMMON_RPC_TESTING_CERTIFICATES_H_

#include <string>

#include "common/rpc/credentials.h"

namespace sinew::rpc {

// Writes a new authority and one certificate signed by it, for the names
// localhost and 127.0.0.1, valid for a day, into `folder` (which exists) under
// names that begin with `prefix`, and returns their paths. Aborts on failure.
Security MakeCertificates(const std::string& folder, const std::string& prefix);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_TESTING_CERTIFICATES_H_
