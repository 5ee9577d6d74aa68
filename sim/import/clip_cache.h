#ifndef SINEW_SIM_IMPORT_CLIP_CACHE_H_
#define SINEW_SIM_IMPORT_CLIP_CACHE_H_

#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "sim/import/clip_report.h"
#include "sim/import/import_clip.h"

namespace sinew::import {

// What the cache keeps of a clip besides its report.
struct CachedClip {
  TensorMap frames;
  SourcePreview preview;  // empty of a robot's clip
};

// Clips that were imported before, in the folder cache/ of a library: what
// makes a second import of the same files do nothing, and of changed ones only
// what changed. A key is the SHA-256 of everything that the result depends on;
// an entry is
//   KEY.json   ClipReport, or why the file could not be imported
//   KEY.clip   frame tensors and preview, in the safetensors format
// KEY.json is written last and names the digest of KEY.clip: an entry is whole
// or it is not there. What cannot be read is not there either.
//
// Thread-safety: yes; different keys do not touch each other. Ownership: none.
// Blocking: on the disk. Errors: those of writing; reading gives NOT_FOUND.
class ClipCache {
 public:
  explicit ClipCache(std::string folder) : folder_(std::move(folder)) {}

  // The report of a clip: verdict and status unset but for an error of reading
  // or fitting; `file` as it was then.
  absl::StatusOr<ClipReport> FindReport(const std::string& key) const;

  // Frames and preview of a clip; DATA_LOSS if they are not those of the
  // report: the entry is removed then.
  absl::StatusOr<CachedClip> Load(const std::string& key) const;

  // `report` is of `clip` (frames and preview are taken from it).
  absl::Status Store(const std::string& key, const ClipReport& report,
                     const ImportedClip& clip) const;
  absl::Status StoreError(const std::string& key,
                          const ClipReport& report) const;

  // Removes all entries but these, and leftovers of writers that died.
  absl::Status KeepOnly(const std::set<std::string>& keys) const;

 private:
  absl::Status WriteReport(const std::string& key, const ClipReport& report,
                           const std::string& clip) const;

  const std::string folder_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_CLIP_CACHE_H_
