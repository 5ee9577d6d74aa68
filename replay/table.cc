#include "replay/table.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/check.h"
#include "common/segment/state_limits.h"
#include "common/status_context.h"
#include "common/status_macros.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;

constexpr std::chrono::milliseconds kStep(100);
constexpr size_t kMaxTaken = size_t{1} << 16;
// Named in a status.
constexpr int kMaxMissing = 1024;

absl::Status OtherRun(const std::string& expected, const std::string& found) {
  if (expected.empty()) {
    return absl::NotFoundError(
        absl::StrCat("run: the table serves none yet, found \"", found, "\""));
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "run: the table serves \"", expected, "\", found \"", found, "\""));
}

}  // namespace

Table::Table(const Options& options, ReplayMetrics& metrics)
    : options_(options),
      metrics_(metrics),
      claim_(options.clock != nullptr ? *options.clock : system_clock_) {
  SINEW_CHECK(options_.limit_bytes >= 1) << options_.limit_bytes;
  metrics_.limit_bytes.Set(static_cast<double>(options_.limit_bytes));
}

Table::~Table() {
  MutexLock lock(mu_);
  SINEW_CHECK(rooms_ == 0) << rooms_;
}

absl::StatusOr<std::vector<Table::Entry>> Table::MakeEntries(
    const v1::OpenRequest& request, const Shared& shared) {
  std::vector<Entry> entries;
  absl::flat_hash_set<int64_t> ids;
  for (const auto& expected : request.expected()) {
    if (!ids.insert(expected.order_id()).second) {
      return absl::InvalidArgumentError(absl::StrCat(
          "open order ", expected.order_id(), ": expected it once"));
    }
    auto expectation = std::make_shared<Expectation>();
    expectation->run_id = request.run_id();
    expectation->expected = expected;
    if (expected.steps() > 0) expectation->layout = shared.layout;
    expectation->limits = shared.limits;
    SINEW_RETURN_IF_ERROR(CheckExpectation(*expectation));
    const int64_t max_bytes = MaxSegmentBytes(*expectation);
    entries.push_back({std::move(expectation), max_bytes, nullptr, 0});
  }
  return entries;
}

absl::Status Table::CheckFits(const std::vector<Entry>& entries) const {
  std::map<int64_t, int64_t> needed;
  for (const auto& [id, entry] : entries_) {
    needed[entry.expectation->expected.iteration()] +=
        entry.segment != nullptr ? entry.bytes : entry.max_bytes;
  }
  for (const Entry& entry : entries) {
    const auto& expected = entry.expectation->expected;
    const auto old = entries_.find(expected.order_id());
    if (old != entries_.end()) {
      if (old->second.expectation->expected.SerializeAsString() ==
          expected.SerializeAsString()) {
        continue;
      }
      return absl::InvalidArgumentError(
          absl::StrCat("open order ", expected.order_id(),
                       ": it is open already with other content"));
    }
    int64_t& bytes = needed[expected.iteration()];
    bytes += std::min(entry.max_bytes, options_.limit_bytes + 1);
    if (bytes > options_.limit_bytes) {
      return absl::ResourceExhaustedError(
          absl::StrCat("replay_bytes: the segments of iteration ",
                       expected.iteration(), " may need ", bytes,
                       " bytes or more, the table has ", options_.limit_bytes));
    }
  }
  return absl::OkStatus();
}

void Table::Insert(Entry entry) {
  const auto& expected = entry.expectation->expected;
  const int64_t id = expected.order_id();
  if (entries_.contains(id)) return;
  if (taken_.erase(id) > 0) {
    taken_order_.erase(std::find(taken_order_.begin(), taken_order_.end(), id));
  }
  missing_bytes_[expected.iteration()] += entry.max_bytes;
  entries_.emplace(id, std::move(entry));
}

void Table::Reset() {
  for (const auto& [id, entry] : entries_) AddBytes(-entry.bytes);
  entries_.clear();
  missing_bytes_.clear();
  taken_order_.clear();
  taken_.clear();
  shared_ = {};
  ++generation_;
}

absl::Status Table::Open(const v1::OpenRequest& request) {
  if (request.run_id().empty()) {
    return absl::InvalidArgumentError("open: run_id: expected one, found \"\"");
  }
  if (request.has_limits()) {
    SINEW_RETURN_IF_ERROR(WithContext(CheckLimits(request.limits()), "open"));
  }
  MutexLock lock(mu_);
  if (request.reset()) {
    SINEW_RETURN_IF_ERROR(WithContext(claim_.Begin(request.run_id()), "open"));
    Reset();
  }
  if (request.run_id() != claim_.run_id()) {
    return OtherRun(claim_.run_id(), request.run_id());
  }
  if (request.ends()) claim_.End();
  Shared shared = shared_;
  if (request.has_layout()) {
    shared.layout = std::make_shared<const v1::SegmentLayout>(request.layout());
  }
  if (request.has_limits()) {
    shared.limits = std::make_shared<const v1::StateLimits>(request.limits());
  }
  SINEW_ASSIGN_OR_RETURN(std::vector<Entry> entries,
                         MakeEntries(request, shared));
  SINEW_RETURN_IF_ERROR(CheckFits(entries));
  shared_ = std::move(shared);
  for (Entry& entry : entries) Insert(std::move(entry));
  changed_.NotifyAll();
  return absl::OkStatus();
}

std::optional<Response> Table::RefuseByKey(const std::string& run_id,
                                           int64_t order_id,
                                           int64_t total_bytes) const {
  if (run_id != claim_.run_id()) {
    return Refuse(order_id, Response::VERDICT_UNEXPECTED,
                  OtherRun(claim_.run_id(), run_id).message());
  }
  const auto found = entries_.find(order_id);
  if (found == entries_.end()) {
    return taken_.contains(order_id)
               ? Refuse(order_id, Response::VERDICT_DUPLICATE,
                        "the order was taken already")
               : Refuse(order_id, Response::VERDICT_UNEXPECTED,
                        "no such open order");
  }
  if (found->second.segment != nullptr) {
    return Refuse(order_id, Response::VERDICT_DUPLICATE,
                  "the first segment stays");
  }
  if (total_bytes < 0 || total_bytes > found->second.max_bytes) {
    return Refuse(
        order_id, Response::VERDICT_MALFORMED,
        absl::StrCat("total_size: expected 0 to ", found->second.max_bytes,
                     " bytes, found ", total_bytes));
  }
  return std::nullopt;
}

bool Table::HasRoom(int64_t iteration, int64_t bytes) const {
  int64_t needed = bytes_ + bytes;
  for (const auto& [earlier, missing] : missing_bytes_) {
    if (earlier >= iteration) break;
    needed += missing;
  }
  return needed <= options_.limit_bytes;
}

absl::Status Table::WaitStep(absl::Time deadline, const Cancelled& cancelled) {
  if (closed_) return absl::UnavailableError("replay is shutting down");
  if (cancelled()) return absl::CancelledError("the caller is gone");
  const absl::Duration left = deadline - absl::Now();
  if (left <= absl::ZeroDuration()) return absl::DeadlineExceededError("");
  const auto step = std::min<std::chrono::nanoseconds>(
      kStep, absl::ToChronoNanoseconds(left));
  changed_.WaitUntil(mu_, std::chrono::steady_clock::now() + step);
  return absl::OkStatus();
}

absl::StatusOr<Table::Admission> Table::Admit(const std::string& run_id,
                                              int64_t order_id,
                                              int64_t total_bytes,
                                              absl::Time deadline,
                                              const Cancelled& cancelled) {
  MutexLock lock(mu_);
  std::optional<absl::Time> waiting_since;
  absl::Status waited;
  Admission admission;
  while (true) {
    admission.refusal = RefuseByKey(run_id, order_id, total_bytes);
    if (admission.refusal.has_value()) break;
    const Entry& entry = entries_.find(order_id)->second;
    if (HasRoom(entry.expectation->expected.iteration(), total_bytes)) {
      admission.room.reset(
          new Room(*this, generation_, total_bytes, entry.expectation));
      break;
    }
    if (!waiting_since.has_value()) {
      waiting_since = absl::Now();
      metrics_.writers_waiting.Increment();
    }
    waited = WaitStep(deadline, cancelled);
    if (!waited.ok()) break;
  }
  if (waiting_since.has_value()) {
    metrics_.writers_waiting.Decrement();
    metrics_.blocked_seconds.Increment(
        std::max(0.0, absl::ToDoubleSeconds(absl::Now() - *waiting_since)));
  }
  if (admission.refusal.has_value()) {
    Count(*admission.refusal);
  } else if (admission.room != nullptr) {
    AddBytes(total_bytes);
    ++rooms_;
  } else {
    return absl::IsDeadlineExceeded(waited)
               ? absl::DeadlineExceededError(absl::StrCat(
                     "replay is full: ", bytes_, " of ", options_.limit_bytes,
                     " bytes; order ", order_id, " needs ", total_bytes))
               : waited;
  }
  return admission;
}

void Table::GiveBack(const Room& room) {
  MutexLock lock(mu_);
  AddBytes(-room.bytes_);
  --rooms_;
  changed_.NotifyAll();
}

void Table::Keep(Room& room, SegmentPtr segment) {
  const auto& expected = room.expectation_->expected;
  Entry& entry = entries_.find(expected.order_id())->second;
  entry.segment = std::move(segment);
  entry.bytes = std::exchange(room.bytes_, 0);
  const auto missing = missing_bytes_.find(expected.iteration());
  missing->second -= entry.max_bytes;
  if (missing->second == 0) missing_bytes_.erase(missing);
}

Response Table::Put(std::unique_ptr<Room> room, absl::string_view bytes) {
  const Expectation& expectation = *room->expectation_;
  const int64_t order_id = expectation.expected.order_id();
  auto segment = std::make_shared<v1::Segment>();
  Response response;
  if (static_cast<int64_t>(bytes.size()) != room->bytes_) {
    response = Refuse(order_id, Response::VERDICT_MALFORMED,
                      absl::StrCat("expected ", room->bytes_, " bytes, found ",
                                   bytes.size()));
  } else {
    response = Judge(expectation, bytes, *segment);
  }
  MutexLock lock(mu_);
  if (response.verdict() == Response::VERDICT_ACCEPTED) {
    // Between Admit and now the run may have been reset, or another actor may
    // have been faster.
    const std::string& run_id =
        room->generation_ == generation_ ? claim_.run_id() : std::string();
    if (auto refusal = RefuseByKey(run_id, order_id, room->bytes_)) {
      response = *std::move(refusal);
    } else {
      Keep(*room, std::move(segment));
    }
  }
  Count(response);
  changed_.NotifyAll();
  return response;
}

absl::StatusOr<std::optional<int64_t>> Table::FirstMissing(
    const std::string& run_id, absl::Span<const int64_t> order_ids) const {
  if (run_id != claim_.run_id()) return OtherRun(claim_.run_id(), run_id);
  std::optional<int64_t> missing;
  for (int64_t id : order_ids) {
    const auto found = entries_.find(id);
    if (found == entries_.end()) {
      return absl::NotFoundError(absl::StrCat(
          "order ", id,
          taken_.contains(id) ? " was taken already" : " is not open"));
    }
    if (found->second.segment == nullptr && !missing.has_value()) missing = id;
  }
  return missing;
}

absl::StatusOr<std::vector<SegmentPtr>> Table::Collect(
    const std::string& run_id, absl::Span<const int64_t> order_ids,
    absl::Time deadline, const Cancelled& cancelled) {
  std::vector<int64_t> sorted(order_ids.begin(), order_ids.end());
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
    return absl::InvalidArgumentError("order_ids: expected each once");
  }
  MutexLock lock(mu_);
  while (true) {
    SINEW_ASSIGN_OR_RETURN(const std::optional<int64_t> missing,
                           FirstMissing(run_id, sorted));
    claim_.Touch();
    if (!missing.has_value()) break;
    const absl::Status waited = WaitStep(deadline, cancelled);
    if (absl::IsDeadlineExceeded(waited)) {
      return absl::DeadlineExceededError(
          absl::StrCat("waited for segments of ", sorted.size(),
                       " orders; the first that is missing is ", *missing));
    }
    SINEW_RETURN_IF_ERROR(waited);
  }
  std::vector<SegmentPtr> segments;
  for (int64_t id : sorted) segments.push_back(entries_.at(id).segment);
  return segments;
}

void Table::Remove(const std::string& run_id,
                   absl::Span<const int64_t> order_ids) {
  MutexLock lock(mu_);
  if (run_id != claim_.run_id()) return;
  for (int64_t id : order_ids) {
    const auto found = entries_.find(id);
    if (found == entries_.end() || found->second.segment == nullptr) continue;
    AddBytes(-found->second.bytes);
    entries_.erase(found);
    taken_.insert(id);
    taken_order_.push_back(id);
    metrics_.taken.Increment();
  }
  while (taken_order_.size() > kMaxTaken) {
    taken_.erase(taken_order_.front());
    taken_order_.pop_front();
  }
  changed_.NotifyAll();
}

v1::GetReplayStatusResponse Table::Status() const {
  MutexLock lock(mu_);
  v1::GetReplayStatusResponse status;
  status.set_bytes(bytes_);
  status.set_limit_bytes(options_.limit_bytes);
  status.set_accepted(accepted_);
  for (const auto& [id, entry] : entries_) {
    if (status.missing_order_ids_size() == kMaxMissing) break;
    if (entry.segment == nullptr) status.add_missing_order_ids(id);
  }
  for (const auto& [verdict, count] : refused_) {
    (*status.mutable_refused())[verdict] = count;
  }
  return status;
}

void Table::Close() {
  MutexLock lock(mu_);
  closed_ = true;
  changed_.NotifyAll();
}

void Table::Count(const Response& response) {
  if (response.verdict() == Response::VERDICT_ACCEPTED) {
    ++accepted_;
    metrics_.accepted.Increment();
    return;
  }
  ++refused_[Response::Verdict_Name(response.verdict())];
  metrics_.refused.at(response.verdict())->Increment();
}

void Table::AddBytes(int64_t bytes) {
  bytes_ += bytes;
  metrics_.bytes.Set(static_cast<double>(bytes_));
}

}  // namespace sinew::replay
