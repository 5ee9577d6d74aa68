#include "actor/service/applied_versions.h"

namespace sinew::actor {
namespace {

constexpr size_t kMost = 8;

}  // namespace

void AppliedVersions::Hear(int64_t version, Time now) {
  MutexLock lock(mu_);
  entries_.try_emplace(version, Entry{.heard = now});
  if (entries_.size() > kMost) entries_.erase(entries_.begin());
}

double AppliedVersions::Apply(int64_t version, Time now) {
  MutexLock lock(mu_);
  const auto found = entries_.find(version);
  if (found == entries_.end()) return 0;
  Entry& entry = found->second;
  if (entry.seconds < 0) {
    entry.seconds = std::chrono::duration<double>(now - entry.heard).count();
    metrics_.publish_to_apply_seconds.Observe(entry.seconds);
    metrics_.applied_policy_version.Set(static_cast<double>(version));
  }
  return entry.seconds;
}

}  // namespace sinew::actor
