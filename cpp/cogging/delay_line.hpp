#pragma once
// The last values of a signal that comes sample by sample.

#include <cstddef>
#include <tuple>
#include <vector>

namespace cogging {

/// A ring that holds the newest value and those before it, back to `longest` samples; 0 before the first.
template <class Scalar>
class DelayLine {
 public:
  explicit DelayLine(std::size_t longest) : values_(longest + 1, Scalar(0.0)) {}

  void push(const Scalar& value) noexcept {
    newest_ = newest_ + 1 == values_.size() ? 0 : newest_ + 1;
    values_[newest_] = value;
  }

  /// The value that was pushed `age` samples before the newest, 0 to `longest`.
  const Scalar& at(std::size_t age) const noexcept {
    return values_[newest_ >= age ? newest_ - age : newest_ + values_.size() - age];
  }

  /// What changes while it runs (see Pid::state).
  auto state() noexcept { return std::tie(newest_, values_); }

 private:
  std::vector<Scalar> values_;
  std::size_t newest_ = 0;
};

}  // namespace cogging
