#include "sim/import/formats/fbx.h"

#include <csignal>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/subprocess.h"
#include "common/temporary_folder.h"
#include "common/workspace_files.h"
#include "proto/sinew/v1/source_clip.pb.h"
#include "sim/import/formats/fbx_reader_protocol.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/source_clip_proto.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

constexpr char kReader[] = "sim/import/formats/fbx_reader";
constexpr int64_t kMaxResultBytes = int64_t{1} << 30;

// What both kinds of FBX begin with, or text soon comes to.
bool LooksLikeFbx(absl::string_view bytes) {
  return absl::StartsWith(bytes, "Kaydara FBX Binary") ||
         absl::StrContains(bytes.substr(0, 4096), "FBXHeaderExtension");
}

std::string Text(const std::optional<double>& number) {
  return number.has_value() ? absl::StrFormat("%.17g", *number) : kFbxUnset;
}

// How the child fared, from its exit.
absl::Status StatusOfExit(const ExitStatus& exit, absl::string_view source,
                          const std::string& out) {
  if (exit.code == kFbxDone && exit.signal == 0) return absl::OkStatus();
  const std::string message = ReadFile(out, /*max_bytes=*/1 << 16).value_or("");
  if (exit.signal == 0 && exit.code == kFbxInvalid) {
    return absl::InvalidArgumentError(message);
  }
  if (exit.signal == 0 && exit.code == kFbxExhausted) {
    return absl::ResourceExhaustedError(message);
  }
  if (exit.signal == SIGXCPU || exit.signal == SIGKILL) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected to be read within ",
                     absl::FormatDuration(kFbxPatience),
                     " and the machine's memory, found the reader killed"));
  }
  if (exit.signal == 0 && exit.code == kFbxBadUsage) {
    return absl::InternalError(absl::StrCat(
        source, ": the FBX reader could not read or write its files"));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": expected an FBX file, found one that the FBX ",
                   "library fails on (", exit.ToString(), ")"));
}

}  // namespace

absl::StatusOr<SourceClip> ParseFbx(absl::string_view bytes,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kFbxMaxBytes, source));
  if (!LooksLikeFbx(bytes)) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected an FBX file, found neither \"Kaydara ",
                     "FBX Binary\" nor \"FBXHeaderExtension\" at its start"));
  }
  SINEW_ASSIGN_OR_RETURN(const std::string reader, FindWorkspaceFile(kReader));
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TemporaryFolder> folder,
                         TemporaryFolder::Create());
  const std::string in = JoinPath(folder->path(), "in.fbx");
  const std::string out = JoinPath(folder->path(), "out");
  SINEW_RETURN_IF_ERROR(AppendToFile(in, bytes));
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<Subprocess> child,
      Subprocess::Start({.argv = {reader, in, out, std::string(source),
                                  Text(options.metres_per_unit),
                                  options.up_axis.has_value()
                                      ? std::string(1, *options.up_axis)
                                      : kFbxUnset,
                                  Text(options.frames_per_second)},
                         .output_file = JoinPath(folder->path(), "log"),
                         .grace = absl::ZeroDuration()}));
  const absl::StatusOr<ExitStatus> exit = child->Wait(kFbxPatience);
  if (absl::IsDeadlineExceeded(exit.status())) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected to be read within ",
                     absl::FormatDuration(kFbxPatience)));
  }
  SINEW_RETURN_IF_ERROR(exit.status());
  SINEW_RETURN_IF_ERROR(StatusOfExit(*exit, source, out));
  SINEW_ASSIGN_OR_RETURN(const std::string result,
                         ReadFile(out, kMaxResultBytes));
  v1::SourceClip proto;
  if (!proto.ParseFromString(result)) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected a clip from the FBX reader, found ",
                     result.size(), " bytes of something else"));
  }
  SINEW_ASSIGN_OR_RETURN(SourceClip clip, FromProto(proto, source));
  clip.name = std::string(name);
  return clip;
}

}  // namespace sinew::import
