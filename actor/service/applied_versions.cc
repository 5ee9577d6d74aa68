#include "actor/service/applied_versions.h"

#include <algorithm>

namespace sinew::actor {
namespace {

constexpr size_t kMost = 8;

}  // namespace

AppliedVersions::Entry* AppliedVersions::Find(int64_t version) {
  const auto found = std::find_if(
      entries_.begin(), entries_.end(),
      [&](const Entry& entry) { return entry.version == version; });
  return found == entries_.end() ? nullptr : &*found;
}

void AppliedVersions::Hear(int64_t version, Time now) {
  MutexLock lock(mu_);
  if (Find(version) != nullptr) return;
  entries_.push_back({.version = version, .heard = now});
  if (entries_.size() > kMost) entries_.pop_front();
}

double AppliedVersions::Apply(int64_t version, Time now) {
  MutexLock lock(mu_);
  metrics_.applied_policy_version.Set(static_cast<double>(version));
  Entry* entry = Find(version);
  if (entry == nullptr) return 0;
  if (entry->seconds < 0) {
    entry->seconds = std::chrono::duration<double>(now - entry->heard).count();
    metrics_.publish_to_apply_seconds.Observe(entry->seconds);
  }
  return entry->seconds;
}

}  // namespace sinew::actor
