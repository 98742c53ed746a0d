#pragma once
// How the caller of a long loop ends it before its time.

#include <algorithm>
#include <chrono>
#include <exception>

namespace cogging {

/// What a loop throws when its caller wants it to end; whatever it had made is lost.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

/// Answers long loops, which ask it from every thread that works for the caller, whether they should end.
class StopRequest {
 public:
  virtual ~StopRequest() = default;
  virtual bool requested(std::chrono::steady_clock::time_point now) = 0;
  bool requested_now() { return requested(std::chrono::steady_clock::now()); }
};

/// Asks a stop request from inside a loop, once in as many rows as pass in a few milliseconds: the others cost a
/// countdown. No request: never stops.
class StopCheck {
 public:
  explicit StopCheck(StopRequest* request) : request_(request) {}

  /// In every row of the loop. Throws Interrupted.
  void row() {
    if (--left_ == 0) ask();
  }

  /// At once, before something that takes long. Throws Interrupted.
  void ask() {
    together_ = std::min(2 * together_, most_together);
    if (request_ != nullptr) {
      const auto now = std::chrono::steady_clock::now();
      if (now - last_ > slow) together_ = 1;
      last_ = now;
      if (request_->requested(now)) throw Interrupted();
    }
    left_ = together_;
  }

 private:
  static constexpr int most_together = 1024;
  static constexpr std::chrono::milliseconds slow{5};
  StopRequest* request_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  int together_ = 1, left_ = 1;
};

}  // namespace cogging
