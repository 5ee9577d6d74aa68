#include "teacher/block_pool.h"

#include "common/check.h"

namespace sinew::teacher {

BlockPool::BlockPool(int workers) {
  SINEW_CHECK(workers >= 1) << workers;
  for (int worker = 1; worker < workers; ++worker) {
    threads_.emplace_back(
        [this, worker](const std::stop_token& stop) { Work(stop, worker); });
  }
}

void BlockPool::Run(int64_t blocks, Task task) {
  // Turns and blocks end by themselves: computing takes milliseconds.
  const std::stop_token never;
  {
    MutexLock lock(mu_);
    while (taken_) changed_.Wait(mu_, never);
    taken_ = true;
    task_ = &task;
    blocks_ = blocks;
    next_ = 0;
    unfinished_ = blocks;
  }
  if (!threads_.empty() && blocks > 1) changed_.NotifyAll();
  RunBlocks(/*worker=*/0);
  {
    MutexLock lock(mu_);
    while (unfinished_ > 0) changed_.Wait(mu_, never);
    taken_ = false;
  }
  changed_.NotifyAll();
}

void BlockPool::Work(const std::stop_token& stop, int worker) {
  while (true) {
    {
      MutexLock lock(mu_);
      while (next_ >= blocks_) {
        if (!changed_.Wait(mu_, stop)) return;
      }
    }
    RunBlocks(worker);
  }
}

void BlockPool::RunBlocks(int worker) {
  mu_.Lock();
  while (next_ < blocks_) {
    const int64_t block = next_++;
    const Task task = *task_;
    mu_.Unlock();
    task(worker, block);
    mu_.Lock();
    if (--unfinished_ == 0) changed_.NotifyAll();
  }
  mu_.Unlock();
}

}  // namespace sinew::teacher
