#pragma once
// How the caller of a long loop ends it before its time.

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
  virtual bool requested() = 0;
};

/// Asks a stop request from inside a loop, once in many rows: a row costs a countdown. Rows that turn out to be slow
/// are looked at one by one. No request: never stops.
class StopCheck {
 public:
  explicit StopCheck(StopRequest* request) : request_(request) {}

  /// In every row of the loop. Throws Interrupted.
  void row() {
    if (--left_ == 0) ask();
  }

  /// At once, before something that takes long. Throws Interrupted.
  void ask() {
    left_ = rows_together;
    if (request_ == nullptr) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ > slow) left_ = 1;
    last_ = now;
    if (request_->requested()) throw Interrupted();
  }

 private:
  static constexpr int rows_together = 64;  // the clock takes as long as a fifth of one row of a simulation
  static constexpr std::chrono::milliseconds slow{5};
  StopRequest* request_;
  std::chrono::steady_clock::time_point last_{};
  int left_ = 1;
};

}  // namespace cogging
