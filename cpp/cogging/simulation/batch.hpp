#pragma once
// Many independent runs at once, on threads.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

#include "cogging/require.hpp"

namespace cogging {

inline constexpr unsigned threads_max = 1024;

/// Calls job(0) to job(count - 1), each once, on `threads` threads (0 = as many as the machine has, 1024 at most).
/// What a job throws is thrown here, of the job with the lowest number, once all threads have ended. The order in
/// which jobs run has no influence on what each does.
///
/// Raises std::invalid_argument for more than 1024 threads, and where the system cannot start as many as are used.
template <class Job>
void run_batch(std::size_t count, unsigned threads, const Job& job) {
  require(threads <= threads_max, "threads", "must be from 0 to " + format(threads_max), threads);
  if (threads == 0) threads = std::max(1u, std::min(threads_max, std::thread::hardware_concurrency()));
  threads = static_cast<unsigned>(std::min<std::size_t>(threads, std::max<std::size_t>(count, 1)));
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        job(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  others.reserve(threads);
  try {
    while (others.size() + 1 < threads) others.emplace_back(work);
  } catch (...) {
    next = count;  // those that run end with the job that they are at
  }
  const bool started = others.size() + 1 == threads;
  if (started) work();
  for (std::thread& other : others) other.join();
  require(started, "threads",
          "must be no more than the system can start, which ended at " + format(static_cast<double>(others.size() + 1)),
          threads);
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace cogging
