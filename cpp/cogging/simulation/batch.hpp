#pragma once
// Many independent runs at once, on threads.

#include <atomic>
#include <functional>
#include <future>
#include <thread>

#include "cogging/interruption.hpp"
#include "cogging/require.hpp"

namespace cogging {

inline constexpr unsigned threads_max = 1024;

/// How many threads are used where `threads` are asked for (0 = as many as the machine has, 1024 at most).
inline unsigned threads_of(unsigned threads) {
  if (threads > threads_max) refuse("threads", "must be from 0 to " + format(threads_max), format(threads));
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
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> interrupted{false};
  const auto work = [&] {  // until no job is left or the batch is interrupted
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        if (stop != nullptr && stop->requested_now()) throw Interrupted();
        job(i);
      } catch (const Interrupted&) {
        interrupted = true;
        return;
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  std::vector<std::future<void>> others;
  others.reserve(threads);
  try {
    while (others.size() + 1 < threads) others.push_back(std::async(std::launch::async, work));
  } catch (...) {
    next = count;  // those that run end with the job that they are at
  }
  const bool started = others.size() + 1 == threads;
  if (started) work();
  // The caller's thread may be the only one that learns of a request; the others then end by themselves.
  for (const std::future<void>& other : others)
    while (other.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready)
      if (stop != nullptr && stop->requested_now()) interrupted = true;
  if (!started)
    refuse("threads", "must be no more than the system can start, which ended at " + format(others.size() + 1),
           format(threads));
  if (interrupted) throw Interrupted();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace cogging
