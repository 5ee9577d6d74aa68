#ifndef SINEW_DEPLOY_RUNTIME_TESTING_RUN_PROGRAM_H_
#define SINEW_DEPLOY_RUNTIME_TESTING_RUN_PROGRAM_H_

#include <string>
#include <vector>

namespace sinew::runtime::testing {

// Programs that lie beside a test, run to their end. Fails the test if one
// cannot be started or takes minutes.

// Path of a file that the test has as data: "sinew/deploy/runtime/...".
std::string Runfile(const std::string& name);

struct Outcome {
  int code = -1;
  std::string output;  // of both streams
};

// `argv`: the program and its arguments. Python finds the package onnx_python.
Outcome RunProgram(std::vector<std::string> argv);

}  // namespace sinew::runtime::testing

#endif  // SINEW_DEPLOY_RUNTIME_TESTING_RUN_PROGRAM_H_
