#include "replay/testing/test_replay.h"

#include <utility>

#include "absl/time/time.h"
#include "common/check.h"
#include "replay/testing/segments.h"
#include "replay/validate.h"

namespace sinew::replay {
namespace {

// Later than all others, which need not wait for it.
constexpr int64_t kLastIteration = 1'000'000;

constexpr auto kNever = [] { return false; };

}  // namespace

int64_t TestReplay::SegmentBytes() {
  return MaxSegmentBytes(MakeExpectation(0));
}

absl::StatusOr<std::vector<SegmentPtr>> TestReplay::Take(
    absl::Span<const int64_t> ids) {
  auto segments = table_.Collect(kRun, ids, absl::InfiniteFuture(), kNever);
  if (segments.ok()) table_.Remove(kRun, ids);
  return segments;
}

std::unique_ptr<Table::Room> TestReplay::OccupyRoom(int64_t order_id) {
  SINEW_CHECK(table_.Open(MakeOpen({order_id}, kLastIteration)).ok());
  auto admission = table_.Admit(kRun, order_id, SegmentBytes(),
                                absl::InfiniteFuture(), kNever);
  SINEW_CHECK(admission.ok() && admission->room != nullptr);
  return std::move(admission->room);
}

}  // namespace sinew::replay
