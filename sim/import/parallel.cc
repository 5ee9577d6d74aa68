#include "sim/import/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace sinew::import {

void ForEachIndex(int count, int threads, const StopToken& stop,
                  absl::FunctionRef<void(int)> task) {
  std::atomic<int> next = 0;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      if (stop.stop_requested()) return;
      task(i);
    }
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
  work();
}

}  // namespace sinew::import
