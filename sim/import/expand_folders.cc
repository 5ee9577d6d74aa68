#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "sim/import/detect_format.h"
#include "sim/import/formats/keyframes.h"
#include "sim/import/read_clip.h"

namespace sinew::import {
namespace {

namespace fs = std::filesystem;

// Enough for DetectFormat, of most files.
constexpr size_t kHead = 64 << 10;
constexpr size_t kPiece = 1 << 20;

std::string ReadHead(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(file.gcount()));
  return head;
}

// Whether keyframes stand behind the beginning of a model: they come last, and
// models may be long. The file is read in pieces, no further than the reader of
// keyframes would go.
bool HoldsKeyframes(const std::string& path, absl::string_view head) {
  if (head.size() < kHead || !absl::StrContains(head, "<mujoco")) return false;
  // The tag may begin in one piece and end in the next.
  constexpr auto kOverlap = static_cast<int64_t>(kKeyframeTag.size()) - 1;
  std::ifstream file(path, std::ios::binary);
  std::string piece(kPiece, '\0');
  for (int64_t start = static_cast<int64_t>(kHead) - kOverlap;
       start < kKeyframesMaxBytes;
       start += static_cast<int64_t>(kPiece) - kOverlap) {
    file.seekg(start);
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto count = static_cast<size_t>(file.gcount());
    if (absl::StrContains(absl::string_view(piece.data(), count),
                          kKeyframeTag)) {
      return true;
    }
    if (count < piece.size()) return false;
  }
  return false;
}

// Notes, licences and tables lie beside clips; only what a person would take
// for a clip is one. Damaged clips are taken, so that the report names them.
bool LooksLikeClip(const std::string& path) {
  const std::string extension = LowerCaseExtension(path);
  if (extension == ".bvh" || extension == ".amc" || extension == ".npz" ||
      extension == ".fbx" || extension == ".c3d") {
    return true;
  }
  if (extension != ".txt" && extension != ".json" && extension != ".csv" &&
      extension != ".xml") {
    return false;
  }
  const std::string head = ReadHead(path);
  const auto format = DetectFormat(path, head);
  if (!format.ok()) return extension == ".xml" && HoldsKeyframes(path, head);
  if (*format == ClipFormat::kDeepMimic) {
    return head.find("\"Frames\"") != std::string::npos;
  }
  if (*format != ClipFormat::kRobotCsv) return true;
  // A table of numbers: one before the first comma of the second line.
  const size_t line =
      head.find('\n') == std::string::npos ? 0 : head.find('\n') + 1;
  double number;
  return absl::SimpleAtod(
      absl::string_view(head).substr(
          line, head.find_first_of(", ;\t\r\n", line) - line),
      &number);
}

absl::Status Walk(const std::string& folder, std::vector<std::string>* files) {
  std::error_code error;
  std::vector<std::string> found;
  auto entry = fs::recursive_directory_iterator(
      folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator();
       entry.increment(error)) {
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    const std::string path = entry->path().string();
    if (LooksLikeClip(path)) found.push_back(path);
  }
  if (error) {
    return absl::UnavailableError(
        absl::StrCat(folder, ": cannot be walked: ", error.message()));
  }
  std::sort(found.begin(), found.end());
  files->insert(files->end(), found.begin(), found.end());
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ExpandFolders(
    const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);  // if it is not there, its report says so
      continue;
    }
    const size_t before = files.size();
    if (absl::Status status = Walk(path, &files); !status.ok()) return status;
    if (files.size() == before) {
      return absl::NotFoundError(
          absl::StrCat(path,
                       ": expected motion clips in this folder, found "
                       "none"));
    }
  }
  return files;
}

}  // namespace sinew::import
