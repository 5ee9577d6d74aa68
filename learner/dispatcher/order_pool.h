#ifndef SINEW_LEARNER_DISPATCHER_ORDER_POOL_H_
#define SINEW_LEARNER_DISPATCHER_ORDER_POOL_H_

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "absl/time/time.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Open work orders and who has been given which: the book-keeping behind the
// dispatcher, without threads or sockets.
//
// An order is waiting, leased (to one actor or more) or gone (retired). Orders
// are handed out by rising id. Once none is waiting, an actor that asks is
// given the order leased longest ago, if that is longer than `reissue_after`
// and the actor does not hold it: whoever is first wins, the other segment is
// a harmless duplicate. An actor that is gone or gives an order back puts it
// back to waiting unless another actor still holds it.
//
// Each adding of an order has a number of its own, Order.issue. Replay's answer
// for an order that was handed over again since says nothing of what replay
// holds now, so it does not finish the order:
//
//   Assign(a) -> order 7, issue 40     a's segment is sent, replay starts again
//   Add({7})                           the learner found its orders forgotten
//   Finish(a, 7, 40)                   late: order 7 waits, as issue 41
//
// At worst an order is run once more, and its second segment is a duplicate.
//
// Thread-safety: none; the dispatcher guards it. Ownership: holds copies of
// the orders. Blocking: never. Errors: unknown ids are ignored, since late
// answers are normal.
class OrderPool {
 public:
  // Issues are counted from `first_issue`. A learner that follows another one
  // begins above all issues of that one: actors may still bring answers to it.
  OrderPool(absl::Duration reissue_after, int64_t first_issue)
      : reissue_after_(reissue_after), next_issue_(first_issue) {}

  // Adds orders; an id that is there already is replaced and waits again.
  void Add(const std::vector<v1::Order>& orders);

  // The next order for `actor` at `now`, or none.
  std::optional<v1::Order> Assign(int64_t actor, absl::Time now);

  // The actor's segment of this issue was answered by replay: its lease ends.
  // The order stays (finished) until retired, and is not handed out again. The
  // actor need not hold it any more, but an earlier issue counts for nothing.
  void Finish(int64_t actor, int64_t order_id, int64_t issue);
  // The actor gives an order back; false: it does not hold it.
  bool Return(int64_t actor, int64_t order_id);
  // The same, because replay refused its segment. Returns how often that
  // happened to an order that still lacks a good one; 0: not held, or it has.
  int Refuse(int64_t actor, int64_t order_id);
  // The actor is gone; all its leases end.
  void Forget(int64_t actor);
  // The learner has the segments: the orders leave the pool.
  void Retire(const std::vector<int64_t>& order_ids);

  // Orders that were finished and not retired, rising.
  std::vector<int64_t> finished() const;
  int64_t waiting() const;
  int64_t leased() const;
  int64_t held_by(int64_t actor) const;
  // Orders given to a second actor so far.
  int64_t reissued() const { return reissued_; }

 private:
  struct Entry {
    v1::Order order;
    std::map<int64_t, absl::Time> leases;  // actor -> since
    bool finished = false;
    int refused = 0;
  };
  bool Release(int64_t actor, Entry& entry);

  absl::Duration reissue_after_;
  int64_t next_issue_;
  std::map<int64_t, Entry> entries_;
  std::set<int64_t> waiting_;
  int64_t reissued_ = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_ORDER_POOL_H_
