#pragma once
// Many independent runs at once, on threads.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "cogging/interruption.hpp"
#include "cogging/require.hpp"

namespace cogging {

inline constexpr unsigned threads_max = 1024;

/// Counts threads down as they end, so that who waits for them can look after other things meanwhile.
class ThreadsAtWork {
 public:
  void one_begins() {
    const std::lock_guard lock(mutex_);
    ++count_;
  }

  void one_ended() {
    const std::lock_guard lock(mutex_);  // held over the notification: who waits takes this object away
    --count_;
    ended_.notify_one();
  }

  /// Whether all have ended, waiting for it at most so long.
  bool all_ended(std::chrono::milliseconds longest) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, longest, [this] { return count_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t count_ = 0;
};

/// The jobs of a batch, taken one after the other by whatever thread is free.
class JobQueue {
 public:
  JobQueue(std::size_t count, StopRequest* stop, const std::function<void(std::size_t)>& job)
      : count_(count), stop_(stop), job_(job), failures_(count) {}

  /// Does jobs until none is left or the batch is interrupted.
  void work() {
    for (std::size_t i = next_++; i < count_; i = next_++) {
      try {
        if (stop_ != nullptr && stop_->requested_now()) throw Interrupted();
        job_(i);
      } catch (const Interrupted&) {
        interrupted_ = true;
        return;
      } catch (...) {
        failures_[i] = std::current_exception();
      }
    }
  }

  void interrupt() { interrupted_ = true; }
  void take_no_more() { next_ = count_; }

  /// Throws what ended the batch, or the job with the lowest number that failed.
  void rethrow() const {
    if (interrupted_) throw Interrupted();
    for (const std::exception_ptr& failure : failures_)
      if (failure) std::rethrow_exception(failure);
  }

 private:
  std::size_t count_;
  StopRequest* stop_;
  const std::function<void(std::size_t)>& job_;
  std::vector<std::exception_ptr> failures_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> interrupted_{false};
};

/// How many threads are used where `threads` are asked for (0 = as many as the machine has, 1024 at most).
inline unsigned threads_of(unsigned threads) {
  require(threads <= threads_max, "threads", "must be from 0 to " + format(threads_max), threads);
  return threads > 0 ? threads : std::max(1u, std::min(threads_max, std::thread::hardware_concurrency()));
}

/// Calls job(0) to job(count - 1), each once, on `threads` threads (0 = as many as the machine has, 1024 at most).
/// What a job throws is thrown here, of the job with the lowest number, once all threads have ended. The order in
/// which jobs run has no influence on what each does. Throws Interrupted, with all threads ended, where `stop` (or
/// none) asks for it: before a job begins, and in jobs that ask it themselves.
///
/// Raises std::invalid_argument for more than 1024 threads, and where the system cannot start as many as are used.
inline void run_batch(std::size_t count, unsigned threads, StopRequest* stop,
                      const std::function<void(std::size_t)>& job) {
  threads = static_cast<unsigned>(std::min<std::size_t>(threads_of(threads), std::max<std::size_t>(count, 1)));
  JobQueue jobs(count, stop, job);
  ThreadsAtWork at_work;
  const auto work_and_end = [&] {
    jobs.work();
    at_work.one_ended();
  };
  std::vector<std::thread> others;
  others.reserve(threads);
  try {
    while (others.size() + 1 < threads) {
      at_work.one_begins();
      others.emplace_back(work_and_end);
    }
  } catch (...) {
    at_work.one_ended();
    jobs.take_no_more();  // those that run end with the job that they are at
  }
  const bool started = others.size() + 1 == threads;
  if (started) jobs.work();
  // The caller's thread may be the only one that learns of a request; the others then end by themselves.
  if (stop != nullptr)
    while (!at_work.all_ended(std::chrono::milliseconds(20)))
      if (stop->requested_now()) jobs.interrupt();
  for (std::thread& other : others) other.join();
  require(started, "threads",
          "must be no more than the system can start, which ended at " + format(static_cast<double>(others.size() + 1)),
          threads);
  jobs.rethrow();
}

}  // namespace cogging
