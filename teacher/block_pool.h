#ifndef SINEW_TEACHER_BLOCK_POOL_H_
#define SINEW_TEACHER_BLOCK_POOL_H_

#include <cstdint>
#include <stop_token>
#include <thread>
#include <vector>

#include "absl/functional/function_ref.h"
#include "common/mutex.h"

namespace sinew::teacher {

// Workers that share out the blocks of a batch. Which worker takes which block
// is left to chance, so what a block computes may depend on the block only; the
// worker's number says whose workspace it may use.
//
//   pool.Run(8, [&](int worker, int64_t block) { ... });
//
// Thread-safety: any thread; callers take turns. Ownership: owns workers - 1
//   threads; the caller is worker 0, so that a pool of one never wakes anybody.
//   No Run may be going on when it is destroyed. Blocking: Run, for the turns
//   of others and until its blocks are done. Errors: those of tasks.
class BlockPool {
 public:
  using Task = absl::FunctionRef<void(int worker, int64_t block)>;

  // `workers` >= 1.
  explicit BlockPool(int workers);
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // The caller included.
  int workers() const { return static_cast<int>(threads_.size()) + 1; }

  // Calls task(worker, block) for blocks 0 ... blocks - 1, each once.
  void Run(int64_t blocks, Task task) SINEW_EXCLUDES(mu_);

 private:
  void Work(const std::stop_token& stop, int worker) SINEW_EXCLUDES(mu_);
  void RunBlocks(int worker) SINEW_EXCLUDES(mu_);

  Mutex mu_;
  CondVar changed_;
  // A caller has its turn.
  bool taken_ SINEW_GUARDED_BY(mu_) = false;
  const Task* task_ SINEW_GUARDED_BY(mu_) = nullptr;
  int64_t blocks_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t next_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t unfinished_ SINEW_GUARDED_BY(mu_) = 0;

  // Last: they use all of the above.
  std::vector<std::jthread> threads_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_BLOCK_POOL_H_
