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
// Thread-safety: none; the dispatcher guards it. Ownership: holds copies of
// the orders. Blocking: never. Errors: unknown ids are ignored, since late
// answers are normal.
class OrderPool {
 public:
  explicit OrderPool(absl::Duration reissue_after)
      : reissue_after_(reissue_after) {}

  // Adds orders; an id that is there already is replaced and waits again.
  void Add(const std::vector<v1::Order>& orders);

  // The next order for `actor` at `now`, or none.
  std::optional<v1::Order> Assign(int64_t actor, absl::Time now);

  // The actor's segment was answered by replay: its lease ends. The order
  // stays (finished) until retired, and is not handed out again.
  void Finish(int64_t actor, int64_t order_id);
  // The actor gives an order back; false: it does not hold it.
  bool Return(int64_t actor, int64_t order_id);
  // The same, because replay refused its segment. Returns how often that
  // happened to an order that still lacks a good one; 0: not held, or it has.
  int Refuse(int64_t actor, int64_t order_id);
  // The actor is gone; all its leases end.
  void Forget(int64_t actor);
  // The learner has the segments: the orders leave the pool.
  void Retire(const std::vector<int64_t>& order_ids);

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
  std::map<int64_t, Entry> entries_;
  std::set<int64_t> waiting_;
  int64_t reissued_ = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_ORDER_POOL_H_
