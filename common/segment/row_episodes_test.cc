#include "common/segment/row_episodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

void AddFlags(absl::string_view name, const std::vector<char>& flags,
              v1::Segment& segment) {
  v1::Tensor& tensor = *segment.add_columns();
  tensor.set_name(std::string(name));
  tensor.set_dtype(v1::DATA_TYPE_UINT8);
  tensor.add_shape(static_cast<int64_t>(flags.size()) / 2);
  tensor.add_shape(2);
  tensor.set_data(std::string(flags.begin(), flags.end()));
}

// Three steps of two environments: the first ends an episode at step 0 and
// another at step 2, the second none.
v1::Segment MakeSegment() {
  v1::Segment segment;
  AddFlags(column::kTerminated, {1, 0, 0, 0, 0, 0}, segment);
  AddFlags(column::kTruncated, {0, 0, 0, 0, 1, 0}, segment);
  segment.add_end_states()->set_episode(7);
  segment.add_end_states()->set_episode(4);
  return segment;
}

TEST(RowEpisodes, CountsBackFromTheEnd) {
  EXPECT_THAT(EpisodesOfRows(MakeSegment()),
              IsOkAndHolds(ElementsAre(5, 4, 6, 4, 6, 4)));
}

TEST(RowEpisodes, RefusesMoreEndsThanEpisodes) {
  v1::Segment segment = MakeSegment();
  segment.mutable_end_states(0)->set_episode(1);

  EXPECT_THAT(
      EpisodesOfRows(segment).status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("end_states[0].episode: expected >= 2, the episodes "
                         "that ended in these rows, found 1")));
}

TEST(RowEpisodes, RefusesAnotherNumberOfEndStates) {
  v1::Segment segment = MakeSegment();
  segment.add_end_states();

  EXPECT_THAT(EpisodesOfRows(segment).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("end_states: expected 2, one per environment, "
                                 "found 3")));
}

}  // namespace
}  // namespace sinew
