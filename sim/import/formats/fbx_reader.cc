// Reads an FBX file in a process of its own; see fbx_reader_protocol.h.
#include <sys/resource.h>

#include <cstdio>
#include <optional>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "sim/import/formats/fbx_clip.h"
#include "sim/import/formats/fbx_limits.h"
#include "sim/import/formats/fbx_reader_protocol.h"
#include "sim/import/formats/source_clip_proto.h"

namespace sinew::import {
namespace {

// `slack`: from the limit that is told to the one that kills.
void Limit(__rlimit_resource resource, int64_t value, int64_t slack = 0) {
  const rlimit limit = {static_cast<rlim_t>(value),
                        static_cast<rlim_t>(value + slack)};
  setrlimit(resource, &limit);
}

void LimitResources(int64_t file_bytes) {
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_CPU, absl::ToInt64Seconds(kFbxPatience), /*slack=*/5);
#if !defined(__SANITIZE_ADDRESS__) && !__has_feature(address_sanitizer) && \
    !__has_feature(thread_sanitizer)
  // Sanitizers reserve terabytes.
  Limit(RLIMIT_AS, kFbxMemory + kFbxMemoryPerByte * file_bytes);
#else
  static_cast<void>(file_bytes);
#endif
}

std::optional<double> Number(const std::string& text) {
  double value;
  if (text == kFbxUnset || !absl::SimpleAtod(text, &value)) return std::nullopt;
  return value;
}

int Run(const std::string& in, const std::string& out,
        const std::string& source, const ReadOptions& options) {
  const auto size = FileSize(in);
  if (!size.ok()) return kFbxBadUsage;
  LimitResources(*size);
  const auto bytes = ReadFile(in, kFbxMaxBytes);
  if (!bytes.ok()) return kFbxBadUsage;
  const auto clip = ReadFbxHere(*bytes, source, options);
  if (clip.ok()) {
    return AppendToFile(out, ToProto(*clip).SerializeAsString()).ok()
               ? kFbxDone
               : kFbxBadUsage;
  }
  if (!AppendToFile(out, clip.status().message()).ok()) return kFbxBadUsage;
  return absl::IsResourceExhausted(clip.status()) ? kFbxExhausted : kFbxInvalid;
}

}  // namespace
}  // namespace sinew::import

int main(int argc, char** argv) {
  using namespace sinew::import;  // NOLINT
  if (argc != 7) {
    std::fprintf(stderr, "usage: fbx_reader IN OUT SOURCE UNIT UP RATE\n");
    return kFbxBadUsage;
  }
  ReadOptions options;
  options.metres_per_unit = Number(argv[4]);
  if (argv[5] != std::string(kFbxUnset)) options.up_axis = argv[5][0];
  options.frames_per_second = Number(argv[6]);
  return Run(argv[1], argv[2], argv[3], options);
}
