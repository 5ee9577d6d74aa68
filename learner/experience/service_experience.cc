#include "learner/experience/service_experience.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/logging.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

// How often replay may forget the orders within one Take.
constexpr int kMaxReopened = 20;
// How often orders may be handed out again within one Take because their
// segments went elsewhere.
constexpr int kMaxRestored = 20;
// How often replay is told that the run ends.
constexpr int kEndAttempts = 3;

v1::OpenRequest::Expected ExpectedOf(const v1::Order& order) {
  v1::OpenRequest::Expected expected;
  expected.set_order_id(order.order_id());
  expected.set_iteration(order.iteration());
  expected.set_snapshot_version(order.snapshot_version());
  expected.set_snapshot_sha256(order.snapshot_sha256());
  expected.set_layout_sha256(order.layout_sha256());
  if (order.kind() == v1::Order::KIND_TRAIN) {
    expected.set_environments(order.states_size());
    expected.set_steps(order.horizon());
  } else {
    expected.set_environments(order.starts_size());
  }
  return expected;
}

bool IsAway(const absl::Status& status) {
  return rpc::IsTransient(status) && !absl::IsResourceExhausted(status) &&
         !absl::IsDeadlineExceeded(status);
}

}  // namespace

ServiceExperience::ServiceExperience(Options options, Dispatcher& dispatcher,
                                     replay::Replay& replay,
                                     BlobRing& snapshots, Clock& clock)
    : options_(std::move(options)),
      dispatcher_(dispatcher),
      replay_(replay),
      snapshots_(snapshots),
      clock_(clock),
      backoff_(options_.backoff, rpc::FreshSeed()) {}

absl::Status ServiceExperience::Publish(const PublishedSnapshot& snapshot) {
  const std::string sha256 = snapshots_.Put(snapshot.bytes);
  if (sha256 != snapshot.sha256) {
    return absl::InternalError(
        absl::StrCat("snapshot ", snapshot.snapshot.version(), ": expected ",
                     snapshot.sha256, ", found ", sha256));
  }
  return absl::OkStatus();
}

absl::Status ServiceExperience::Open(const std::vector<v1::Order>& orders,
                                     bool reset) {
  v1::OpenRequest request;
  request.set_run_id(options_.run_id);
  request.set_reset(reset);
  *request.mutable_layout() = options_.layout;
  *request.mutable_limits() = options_.limits;
  for (const v1::Order& order : orders) {
    *request.add_expected() = ExpectedOf(order);
  }
  return replay_.Open(request, options_.stop);
}

absl::Status ServiceExperience::Reopen() {
  std::vector<v1::Order> orders;
  for (const auto& [id, order] : open_orders_) orders.push_back(order);
  SINEW_RETURN_IF_ERROR(Open(orders, /*reset=*/true));
  must_reopen_ = false;
  backoff_.Reset();
  dispatcher_.Add(orders);
  return absl::OkStatus();
}

absl::Status ServiceExperience::Begin(const std::vector<v1::Order>& orders) {
  for (const v1::Order& order : orders) open_orders_[order.order_id()] = order;
  absl::Status status;
  if (must_reopen_) {
    status = Reopen();
  } else {
    status = Open(orders, /*reset=*/false);
    if (status.ok()) dispatcher_.Add(orders);
    // It was started again and holds no run.
    if (absl::IsNotFound(status)) status = Reopen();
  }
  if (!IsAway(status) && !absl::IsDeadlineExceeded(status)) return status;
  // Take tries again, for as long as it takes, or hears of the stop.
  must_reopen_ = true;
  if (!options_.stop.stop_requested()) {
    LogWarning("replay is away", {{"error", status.message()}});
  }
  return absl::OkStatus();
}

void ServiceExperience::End() {
  if (options_.stop.stop_requested()) return;
  v1::OpenRequest request;
  request.set_run_id(options_.run_id);
  request.set_ends(true);
  const absl::Status status = rpc::Retry(
      rpc::Backoff(options_.backoff, rpc::FreshSeed()), kEndAttempts,
      [this](absl::Duration wait) { return rpc::WaitFor(wait, options_.stop); },
      [&] { return replay_.Open(request, options_.stop); });
  // One that forgot the run lets another one have it anyway.
  if (status.ok() || absl::IsNotFound(status)) return;
  LogWarning("replay was not told of the run's end",
             {{"error", status.message()}});
}

absl::StatusOr<std::optional<std::vector<replay::SegmentPtr>>>
ServiceExperience::TryTake(const std::vector<int64_t>& order_ids, Wait& wait) {
  absl::Status status;
  if (options_.stop.stop_requested() && must_reopen_) {
    status = absl::CancelledError("stopped");
  } else if (must_reopen_) {
    status = Reopen();
  }
  if (status.ok()) {
    auto taken =
        replay_.Take(options_.run_id, order_ids, options_.step, options_.stop);
    if (taken.ok()) return std::make_optional(*std::move(taken));
    status = taken.status();
  }
  if (options_.stop.stop_requested()) {
    return absl::CancelledError("stopped while waiting for segments");
  }
  if (IsAway(status)) {
    if (!must_reopen_) {
      LogWarning("replay is away", {{"error", status.message()}});
    }
    must_reopen_ = true;
    rpc::WaitFor(backoff_.Next(), options_.stop);
  } else if (absl::IsNotFound(status) && ++wait.reopened <= kMaxReopened) {
    LogWarning("replay has forgotten orders; giving them out again",
               {{"error", status.message()}});
    must_reopen_ = true;
  } else if (!absl::IsDeadlineExceeded(status)) {
    return status;
  }
  SINEW_RETURN_IF_ERROR(CheckProgress(status, wait));
  return std::nullopt;
}

absl::Status ServiceExperience::CheckProgress(const absl::Status& missing,
                                              Wait& wait) {
  if (options_.check) SINEW_RETURN_IF_ERROR(options_.check());
  SINEW_RETURN_IF_ERROR(dispatcher_.failure());
  const Clock::TimePoint now = clock_.SteadyNow();
  const int64_t actors = dispatcher_.statistics().actors;
  // Before replay is asked: what is finished by then is there, or nowhere.
  const std::vector<int64_t> finished = dispatcher_.Finished();
  // One that is away need not be waited for twice.
  absl::StatusOr<v1::GetReplayStatusResponse> status = missing;
  if (!must_reopen_) status = replay_.GetStatus(options_.stop);
  if (status.ok()) SINEW_RETURN_IF_ERROR(Restore(finished, *status, wait));
  const int64_t accepted = status.ok() ? status->accepted() : wait.accepted;
  if (accepted != wait.accepted || actors == 0) {
    wait.accepted = accepted;
    wait.give_up = clock_.After(options_.patience);
  }
  if (now >= wait.give_up) {
    return absl::DeadlineExceededError(
        absl::StrCat("no segment in ", absl::FormatDuration(options_.patience),
                     " from ", actors, " actors: ", missing.message()));
  }
  if (now < wait.next_log) return absl::OkStatus();
  wait.next_log = clock_.After(options_.log_period);
  if (actors == 0) {
    LogWarning("no actors: they are expected at the dispatcher's address",
               {{"address", options_.address}});
  } else {
    LogInfo("waiting for segments",
            {{"actors", actors}, {"missing", missing.message()}});
  }
  return absl::OkStatus();
}

absl::Status ServiceExperience::Restore(
    const std::vector<int64_t>& finished,
    const v1::GetReplayStatusResponse& replay, Wait& wait) {
  std::vector<v1::Order> orders;
  for (const int64_t id : replay.missing_order_ids()) {
    const auto order = open_orders_.find(id);
    if (order != open_orders_.end() &&
        std::binary_search(finished.begin(), finished.end(), id)) {
      orders.push_back(order->second);
    }
  }
  if (orders.empty()) return absl::OkStatus();
  const int64_t first = orders.front().order_id();
  if (++wait.restored > kMaxRestored) {
    return absl::FailedPreconditionError(absl::StrCat(
        "order ", first, ": actors have said ", wait.restored,
        " times that replay answered its segment, and replay misses it: do "
        "they send to another replay?"));
  }
  LogWarning("replay misses segments that actors call done; given out again",
             {{"orders", orders.size()}, {"first", first}});
  dispatcher_.Add(orders);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<v1::Segment>> ServiceExperience::Take(
    const std::vector<int64_t>& order_ids) {
  Wait wait;
  wait.next_log = clock_.After(options_.log_period);
  wait.give_up = clock_.After(options_.patience);
  std::optional<std::vector<replay::SegmentPtr>> taken;
  while (!taken) {
    SINEW_ASSIGN_OR_RETURN(taken, TryTake(order_ids, wait));
  }
  dispatcher_.Retire(order_ids);
  std::map<int64_t, const v1::Segment*> by_id;
  for (const replay::SegmentPtr& segment : *taken) {
    by_id[segment->order_id()] = segment.get();
  }
  std::vector<v1::Segment> result;
  for (int64_t id : order_ids) {
    open_orders_.erase(id);
    const auto found = by_id.find(id);
    if (found == by_id.end()) {
      return absl::InternalError(
          absl::StrCat("replay gave no segment of order ", id));
    }
    result.push_back(*found->second);
  }
  return result;
}

}  // namespace sinew::learner
