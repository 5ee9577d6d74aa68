#include "learner/dispatcher/order_pool.h"

#include <algorithm>

namespace sinew::learner {

void OrderPool::Add(const std::vector<v1::Order>& orders) {
  for (const v1::Order& order : orders) {
    Entry& entry = entries_[order.order_id()];
    entry = Entry();
    entry.order = order;
    entry.order.set_issue(next_issue_++);
    waiting_.insert(order.order_id());
  }
}

std::optional<v1::Order> OrderPool::Assign(int64_t actor, absl::Time now) {
  if (!waiting_.empty()) {
    const int64_t id = *waiting_.begin();
    waiting_.erase(waiting_.begin());
    Entry& entry = entries_.at(id);
    entry.leases[actor] = now;
    return entry.order;
  }
  Entry* latest = nullptr;
  absl::Time oldest = now - reissue_after_;
  for (auto& [id, entry] : entries_) {
    if (entry.finished || entry.leases.empty()) continue;
    if (entry.leases.contains(actor)) continue;
    // The most recent lease counts: one late order is not handed to everybody.
    absl::Time since = absl::InfinitePast();
    for (const auto& [holder, start] : entry.leases) {
      since = std::max(since, start);
    }
    if (since <= oldest) {
      oldest = since;
      latest = &entry;
    }
  }
  if (latest == nullptr) return std::nullopt;
  latest->leases[actor] = now;
  ++reissued_;
  return latest->order;
}

void OrderPool::Finish(int64_t actor, int64_t order_id, int64_t issue) {
  auto it = entries_.find(order_id);
  if (it == entries_.end() || it->second.order.issue() != issue) return;
  it->second.leases.erase(actor);
  it->second.finished = true;
  waiting_.erase(order_id);
}

bool OrderPool::Release(int64_t actor, Entry& entry) {
  if (entry.leases.erase(actor) == 0) return false;
  if (entry.leases.empty() && !entry.finished) {
    waiting_.insert(entry.order.order_id());
  }
  return true;
}

bool OrderPool::Return(int64_t actor, int64_t order_id) {
  auto it = entries_.find(order_id);
  return it != entries_.end() && Release(actor, it->second);
}

int OrderPool::Refuse(int64_t actor, int64_t order_id) {
  auto it = entries_.find(order_id);
  if (it == entries_.end() || !Release(actor, it->second)) return 0;
  return it->second.finished ? 0 : ++it->second.refused;
}

void OrderPool::Forget(int64_t actor) {
  for (auto& [id, entry] : entries_) Release(actor, entry);
}

void OrderPool::Retire(const std::vector<int64_t>& order_ids) {
  for (int64_t id : order_ids) {
    waiting_.erase(id);
    entries_.erase(id);
  }
}

std::vector<int64_t> OrderPool::finished() const {
  std::vector<int64_t> ids;
  for (const auto& [id, entry] : entries_) {
    if (entry.finished) ids.push_back(id);
  }
  return ids;
}

int64_t OrderPool::waiting() const {
  return static_cast<int64_t>(waiting_.size());
}

int64_t OrderPool::leased() const {
  return std::count_if(entries_.begin(), entries_.end(), [](const auto& item) {
    return !item.second.leases.empty();
  });
}

int64_t OrderPool::held_by(int64_t actor) const {
  return std::count_if(
      entries_.begin(), entries_.end(),
      [actor](const auto& item) { return item.second.leases.contains(actor); });
}

}  // namespace sinew::learner
