#include "common/policy/executor.h"

#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/policy/aligned_buffer.h"
#include "common/policy/linear_kernel.h"
#include "common/policy/plan.h"
#include "common/policy/row_ops.h"

namespace sinew::policy {
namespace {

using internal::AlignedBuffer;
using internal::Plan;
using internal::Rows;

class GraphExecutor : public Executor {
 public:
  GraphExecutor(std::shared_ptr<const WeightsPack> pack, int max_batch);

  int input_index(absl::string_view name) const override;
  int tap_index(absl::string_view name) const override;
  int64_t input_width(int input) const override { return values_[input].width; }
  int64_t tap_width(int tap) const override {
    return values_[plan().taps[tap].value].width;
  }
  absl::Span<float> input(int input) override {
    return {inputs_[input].data(),
            static_cast<size_t>(max_batch_ * input_width(input))};
  }
  void Run(int batch) override;
  absl::Span<const float> tap(int tap) const override {
    return {taps_[tap].data(),
            static_cast<size_t>(max_batch_ * tap_width(tap))};
  }
  absl::Status SetWeights(std::shared_ptr<const WeightsPack> pack) override;

 private:
  const Plan& plan() const { return pack_->plan(); }

  std::shared_ptr<const WeightsPack> pack_;
  const int max_batch_;
  // Dense, for the caller.
  std::vector<AlignedBuffer> inputs_;
  std::vector<AlignedBuffer> taps_;
  // Padded, one per value of the plan.
  std::vector<AlignedBuffer> buffers_;
  std::vector<Rows> values_;
  AlignedBuffer patches_;
  AlignedBuffer results_;
};

GraphExecutor::GraphExecutor(std::shared_ptr<const WeightsPack> pack,
                             int max_batch)
    : pack_(std::move(pack)),
      max_batch_(max_batch),
      patches_(plan().patch_elements),
      results_(plan().result_elements) {
  const int64_t rows = internal::RoundUp(max_batch, internal::kRowBlock);
  for (const internal::Value& value : plan().values) {
    buffers_.emplace_back(rows * value.stride);
    values_.push_back({.data = buffers_.back().data(),
                       .stride = value.stride,
                       .width = value.width});
  }
  for (int i = 0; i < plan().num_inputs; ++i) {
    inputs_.emplace_back(max_batch * values_[i].width);
  }
  for (const Plan::Tap& tap : plan().taps) {
    taps_.emplace_back(max_batch * values_[tap.value].width);
  }
}

int GraphExecutor::input_index(absl::string_view name) const {
  for (int i = 0; i < plan().num_inputs; ++i) {
    if (plan().values[i].name == name) return i;
  }
  return -1;
}

int GraphExecutor::tap_index(absl::string_view name) const {
  for (size_t i = 0; i < plan().taps.size(); ++i) {
    if (plan().taps[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

void GraphExecutor::Run(int batch) {
  SINEW_CHECK(batch >= 0 && batch <= max_batch_)
      << "batch " << batch << ", expected at most " << max_batch_;
  for (size_t i = 0; i < inputs_.size(); ++i) {
    const Rows& value = values_[i];
    for (int64_t r = 0; r < batch; ++r) {
      std::memcpy(value.row(r), inputs_[i].data() + r * value.width,
                  value.width * sizeof(float));
    }
  }
  for (const internal::Step& step : plan().steps) {
    internal::RunStep({.step = step,
                       .batch = batch,
                       .values = values_,
                       .parameters = pack_->parameters(step),
                       .patches = patches_.data(),
                       .results = results_.data()});
  }
  for (size_t i = 0; i < taps_.size(); ++i) {
    const Rows& value = values_[plan().taps[i].value];
    for (int64_t r = 0; r < batch; ++r) {
      std::memcpy(taps_[i].data() + r * value.width, value.row(r),
                  value.width * sizeof(float));
    }
  }
}

absl::Status GraphExecutor::SetWeights(
    std::shared_ptr<const WeightsPack> pack) {
  if (pack->plan().identity != plan().identity) {
    return absl::InvalidArgumentError(
        "SetWeights: expected weights of the same graph, found another graph");
  }
  pack_ = std::move(pack);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Executor>> Executor::Create(
    std::shared_ptr<const WeightsPack> pack, int max_batch) {
  constexpr int kMostRows = 1 << 16;
  constexpr int64_t kMostElements = int64_t{1} << 30;  // 4 GiB
  if (max_batch < 1 || max_batch > kMostRows) {
    return absl::InvalidArgumentError(absl::StrCat(
        "max_batch: expected 1 to ", kMostRows, ", found ", max_batch));
  }
  int64_t columns = 0;
  for (const internal::Value& value : pack->plan().values) {
    columns += value.stride;
  }
  if (columns * max_batch > kMostElements) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "expected a workspace of at most ", kMostElements, " elements, found ",
        columns, " columns x ", max_batch, " rows"));
  }
  return std::make_unique<GraphExecutor>(std::move(pack), max_batch);
}

}  // namespace sinew::policy
