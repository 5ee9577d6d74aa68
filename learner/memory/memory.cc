#include "learner/memory/memory.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/random/philox.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

// Nothing that has a valid row is forgotten for good.
constexpr float kLeastPriority = 1e-6F;

bool HasValidRow(const SequencesView& view, int64_t sequence, int64_t steps) {
  const auto valid = view.valid.subspan(sequence * steps, steps);
  return std::any_of(valid.begin(), valid.end(),
                     [](float flag) { return flag != 0; });
}

absl::Status Damaged(absl::string_view field, absl::string_view expected,
                     absl::string_view found) {
  return absl::DataLossError(absl::StrCat("training state: memory.", field,
                                          ": expected ", expected, ", found ",
                                          found));
}

absl::Status CheckPriorities(const v1::MemoryState::Chunk& chunk,
                             int64_t sequences) {
  const std::string field = absl::StrCat("chunk ", chunk.sha256());
  if (chunk.sequences() != sequences) {
    return Damaged(field, absl::StrCat(sequences, " sequences"),
                   absl::StrCat(chunk.sequences()));
  }
  if (chunk.priorities_size() != sequences) {
    return Damaged(field, absl::StrCat(sequences, " priorities"),
                   absl::StrCat(chunk.priorities_size()));
  }
  for (const float priority : chunk.priorities()) {
    if (priority >= 0 && std::isfinite(priority)) continue;
    return Damaged(field, "finite priorities >= 0", absl::StrCat(priority));
  }
  return absl::OkStatus();
}

}  // namespace

float Memory::LargestPriority() const {
  float largest = 0;
  for (const Held& held : held_) {
    for (const float priority : held.priorities) {
      largest = std::max(largest, priority);
    }
  }
  return largest > 0 ? largest : 1;
}

void Memory::Insert(int64_t order_id, StateChunk chunk) {
  Held held;
  held.order_id = order_id;
  auto view = ViewOwnChunk(chunk, options_.shape);
  SINEW_CHECK(view.ok()) << view.status().ToString();
  held.view = *view;
  held.chunk = std::move(chunk);
  const float priority = LargestPriority();
  const int64_t steps = options_.shape.steps;
  for (int64_t i = 0; i < held.view.sequences; ++i) {
    held.priorities.push_back(HasValidRow(held.view, i, steps) ? priority : 0);
  }
  sequences_ += held.view.sequences;
  inserted_rows_ += held.view.sequences * steps;
  held_.push_back(std::move(held));
  while (rows() > options_.recipe.rows() && held_.size() > 1) {
    sequences_ -= held_.front().view.sequences;
    held_.pop_front();
  }
}

int64_t Memory::DueMinibatches(int64_t minibatch_rows) const {
  const double due =
      options_.samples_per_insert * static_cast<double>(inserted_rows_) -
      static_cast<double>(sampled_rows_);
  return std::max<int64_t>(0, static_cast<int64_t>(std::floor(
                                  due / static_cast<double>(minibatch_rows))));
}

std::vector<double> Memory::Weights() const {
  std::vector<double> weights;
  weights.reserve(sequences_);
  const double exponent = options_.recipe.priority_exponent();
  for (const Held& held : held_) {
    for (const float priority : held.priorities) {
      if (!prioritised()) {
        weights.push_back(1);
      } else {
        weights.push_back(priority == 0 ? 0 : std::pow(priority, exponent));
      }
    }
  }
  return weights;
}

std::vector<Memory::Reference> Memory::Select(int64_t count,
                                              uint64_t draw) const {
  std::vector<double> sums = Weights();
  double sum = 0;
  for (double& weight : sums) weight = sum += weight;
  if (!(sum > 0)) return {};
  std::vector<Reference> all;
  all.reserve(sums.size());
  for (size_t c = 0; c < held_.size(); ++c) {
    for (int64_t s = 0; s < held_[c].view.sequences; ++s) {
      all.push_back({static_cast<int32_t>(c), static_cast<int32_t>(s)});
    }
  }
  const RandomKey key = {.seed = options_.seed,
                         .environment = draw,
                         .purpose = RandomPurpose::kSelection};
  std::vector<Reference> selected;
  for (int64_t i = 0; i < count; ++i) {
    // The first whose sum is above the mark: those of weight 0 never are.
    const double mark = Uniform(key, static_cast<uint64_t>(i)) * sum;
    const auto found = std::upper_bound(sums.begin(), sums.end(), mark);
    const size_t index = std::min<size_t>(found - sums.begin(), all.size() - 1);
    selected.push_back(all[index]);
  }
  return selected;
}

Memory::Sequence Memory::At(Reference reference) const {
  const SequenceShape& shape = options_.shape;
  const SequencesView& view = held_[reference.chunk].view;
  const int64_t row = reference.sequence * shape.steps;
  return {.observation = view.observation.subspan(
              row * shape.observation, shape.steps * shape.observation),
          .label = view.label.subspan(row * shape.action,
                                      shape.steps * shape.action),
          .valid = view.valid.subspan(row, shape.steps),
          .linked = view.linked.subspan(row, shape.steps)};
}

void Memory::SetPriority(Reference reference, float priority) {
  if (!prioritised()) return;
  SINEW_CHECK(priority >= 0 && std::isfinite(priority)) << priority;
  held_[reference.chunk].priorities[reference.sequence] =
      std::max(priority, kLeastPriority);
}

void Memory::Save(v1::MemoryState& state) const {
  state.Clear();
  state.set_inserted_rows(inserted_rows_);
  state.set_sampled_rows(sampled_rows_);
  for (const Held& held : held_) {
    v1::MemoryState::Chunk& chunk = *state.add_chunks();
    chunk.set_sha256(held.chunk.sha256);
    chunk.set_order_id(held.order_id);
    chunk.set_sequences(static_cast<int32_t>(held.view.sequences));
    chunk.mutable_priorities()->Assign(held.priorities.begin(),
                                       held.priorities.end());
  }
}

std::vector<StateChunk> Memory::chunks() const {
  std::vector<StateChunk> chunks;
  for (const Held& held : held_) chunks.push_back(held.chunk);
  return chunks;
}

absl::Status Memory::Restore(const v1::MemoryState& state,
                             absl::Span<const StateChunk> chunks) {
  if (state.chunks_size() != static_cast<int>(chunks.size())) {
    return Damaged("chunks", absl::StrCat(state.chunks_size(), " chunks"),
                   absl::StrCat(chunks.size()));
  }
  if (state.inserted_rows() < 0 || state.sampled_rows() < 0) {
    return Damaged(
        "inserted_rows and sampled_rows", ">= 0",
        absl::StrCat(state.inserted_rows(), " and ", state.sampled_rows()));
  }
  std::deque<Held> held;
  int64_t sequences = 0;
  for (int i = 0; i < state.chunks_size(); ++i) {
    const v1::MemoryState::Chunk& named = state.chunks(i);
    if (named.sha256() != chunks[i].sha256) {
      return Damaged("chunks", absl::StrCat("SHA-256 ", named.sha256()),
                     chunks[i].sha256);
    }
    SINEW_ASSIGN_OR_RETURN(const SequencesView view,
                           ViewChunk(chunks[i], options_.shape));
    SINEW_RETURN_IF_ERROR(CheckPriorities(named, view.sequences));
    held.push_back({chunks[i],
                    named.order_id(),
                    view,
                    {named.priorities().begin(), named.priorities().end()}});
    sequences += view.sequences;
  }
  held_ = std::move(held);
  sequences_ = sequences;
  inserted_rows_ = state.inserted_rows();
  sampled_rows_ = state.sampled_rows();
  return absl::OkStatus();
}

}  // namespace sinew::learner
