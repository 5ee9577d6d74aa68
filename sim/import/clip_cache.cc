#include "sim/import/clip_cache.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "google/protobuf/util/json_util.h"

namespace sinew::import {
namespace {

using Json = nlohmann::json;

// Of the entries' own format.
constexpr int kEntryVersion = 2;
constexpr int64_t kMaxReportBytes = int64_t{64} << 20;
// Tensors of an entry that are no frames.
constexpr char kPositions[] = "preview/positions";
constexpr char kParents[] = "preview/parents";
constexpr char kRate[] = "preview/frames_per_second";

std::string ReportPath(const std::string& folder, const std::string& key) {
  return JoinPath(folder, absl::StrCat(key, ".json"));
}

std::string ClipPath(const std::string& folder, const std::string& key) {
  return JoinPath(folder, absl::StrCat(key, ".clip"));
}

void AddPreview(const SourcePreview& preview, TensorMap* tensors) {
  if (preview.frames() == 0) return;
  const int64_t joints = preview.joints();
  const std::vector<float> parents(preview.parents.begin(),
                                   preview.parents.end());
  (*tensors)[kPositions] =
      HostTensor::Float32({preview.frames(), joints, 3}, preview.positions);
  (*tensors)[kParents] = HostTensor::Float32({joints}, parents);
  (*tensors)[kRate] =
      HostTensor::Float32({1}, {static_cast<float>(preview.frames_per_second)});
}

// Takes the preview out of an entry's tensors; empty if it has none, as those
// of a robot's clip, which has no skeleton of its own.
SourcePreview TakePreview(TensorMap* tensors) {
  auto positions = tensors->extract(kPositions);
  auto parents = tensors->extract(kParents);
  auto rate = tensors->extract(kRate);
  SourcePreview preview;
  if (!positions || !parents || !rate) return preview;
  const auto values = positions.mapped().float32();
  preview.positions.assign(values.begin(), values.end());
  for (const float parent : parents.mapped().float32()) {
    preview.parents.push_back(static_cast<int>(std::lround(parent)));
  }
  preview.frames_per_second = rate.mapped().float32()[0];
  return preview;
}

absl::StatusOr<Json> ToJson(const ClipReport& report, const std::string& clip) {
  Json json = {{"version", kEntryVersion},
               {"file", report.file},
               {"code", static_cast<int>(report.status.code())},
               {"message", std::string(report.status.message())},
               {"duration_s", report.duration_s},
               {"retiming", report.retiming},
               {"supported_share", report.supported_share},
               {"warnings", report.warnings},
               {"core_seconds", report.core_seconds},
               {"clip_bytes", clip.size()},
               {"clip_sha256", Sha256Hex(clip)}};
  std::string info;
  const auto printed =
      google::protobuf::util::MessageToJsonString(report.info, &info);
  if (!printed.ok()) {
    return absl::InternalError(absl::StrCat(
        report.file, ": cache entry: ", std::string(printed.message())));
  }
  json["info"] = std::move(info);
  return json;
}

absl::Status NotThere(const std::string& key) {
  return absl::NotFoundError(absl::StrCat("no cached clip ", key));
}

// Throws what nlohmann::json throws where the entry is not ours.
absl::StatusOr<ClipReport> FromJson(const Json& json, const std::string& key) {
  if (json.at("version") != kEntryVersion) return NotThere(key);
  ClipReport report;
  report.file = json.at("file");
  report.status =
      absl::Status(static_cast<absl::StatusCode>(json.at("code").get<int>()),
                   json.at("message").get<std::string>());
  report.duration_s = json.at("duration_s");
  report.retiming = json.at("retiming");
  report.supported_share = json.at("supported_share");
  report.warnings = json.at("warnings").get<std::vector<std::string>>();
  report.core_seconds = json.at("core_seconds");
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      json.at("info").get<std::string>(), &report.info);
  if (!parsed.ok()) return NotThere(key);
  report.cache_key = key;
  report.from_cache = true;
  return report;
}

absl::StatusOr<Json> ReadJson(const std::string& path, const std::string& key) {
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(path, kMaxReportBytes));
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return NotThere(key);
  return json;
}

}  // namespace

absl::StatusOr<ClipReport> ClipCache::FindReport(const std::string& key) const {
  const auto json = ReadJson(ReportPath(folder_, key), key);
  if (!json.ok()) return NotThere(key);
  try {
    SINEW_ASSIGN_OR_RETURN(ClipReport report, FromJson(*json, key));
    if (!report.measured()) return report;
    const auto bytes = FileSize(ClipPath(folder_, key));
    if (!bytes.ok() || *bytes != json->at("clip_bytes").get<int64_t>()) {
      return NotThere(key);
    }
    return report;
  } catch (const Json::exception&) {
    return NotThere(key);
  }
}

absl::StatusOr<CachedClip> ClipCache::Load(const std::string& key) const {
  SINEW_ASSIGN_OR_RETURN(const Json json,
                         ReadJson(ReportPath(folder_, key), key));
  const std::string path = ClipPath(folder_, key);
  SINEW_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  const std::string found = Sha256Hex(bytes);
  const Json expected = json.value("clip_sha256", Json());
  if (expected != Json(found)) {
    SINEW_RETURN_IF_ERROR(RemoveRecursively(ReportPath(folder_, key)));
    return absl::DataLossError(
        absl::StrCat(path, ": expected SHA-256 ", expected.dump(), ", found ",
                     found, ": altered; the next import makes it anew"));
  }
  CachedClip clip;
  SINEW_ASSIGN_OR_RETURN(clip.frames, ParseSafetensors(bytes, path));
  clip.preview = TakePreview(&clip.frames);
  return clip;
}

absl::Status ClipCache::WriteReport(const std::string& key,
                                    const ClipReport& report,
                                    const std::string& clip) const {
  SINEW_ASSIGN_OR_RETURN(const Json json, ToJson(report, clip));
  return WriteFileAtomically(ReportPath(folder_, key),
                             json.dump(-1, ' ', /*ensure_ascii=*/false,
                                       Json::error_handler_t::replace));
}

absl::Status ClipCache::Store(const std::string& key, const ClipReport& report,
                              const ImportedClip& clip) const {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder_));
  TensorMap tensors = clip.frames;
  AddPreview(clip.preview, &tensors);
  const std::string bytes = SerializeSafetensors(tensors);
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(ClipPath(folder_, key), bytes));
  return WriteReport(key, report, bytes);
}

absl::Status ClipCache::StoreError(const std::string& key,
                                   const ClipReport& report) const {
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder_));
  return WriteReport(key, report, "");
}

absl::Status ClipCache::KeepOnly(const std::set<std::string>& keys) const {
  if (!FileExists(folder_)) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         ListDirectory(folder_));
  for (const std::string& name : names) {
    if (keys.contains(name.substr(0, name.find('.'))) &&
        !IsTemporaryName(name)) {
      continue;
    }
    SINEW_RETURN_IF_ERROR(RemoveRecursively(JoinPath(folder_, name)));
  }
  return absl::OkStatus();
}

}  // namespace sinew::import
