#pragma once
// The motion of a run at its sample times: computed once, for one run or for all that follow it at this rate.

#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "cogging/interruption.hpp"
#include "cogging/plant/axis.hpp"
#include "cogging/reference/reference.hpp"
#include "cogging/reference/sampled.hpp"
#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Row k is the motion at k / sample_rate. Rows beyond `kept_most` are not kept but computed again for each run, so
/// that the memory of a run that keeps no rows has a bound.
///
/// Raises std::invalid_argument for a motion without an end and no duration, or less than 1 or more than 1e9 samples.
class ReferenceRows {
 public:
  static constexpr std::size_t kept_by_default = std::size_t{1} << 20;  // 24 MB

  ReferenceRows(const Reference& reference, double duration, double sample_rate, StopCheck& stop,
                std::size_t kept_most = kept_by_default)
      : reference_(&reference),
        sample_rate_(sample_rate),
        count_(count(reference, duration, sample_rate)),
        kept_(std::min(count_, kept_most)) {
    for (auto* column : {&position_, &velocity_, &acceleration_}) {
      stop.ask();  // a column of a long run takes long to clear
      column->resize(kept_);
    }
    const auto* samples = dynamic_cast<const Sampled*>(&reference);
    for (std::size_t k = 0; k < count_; ++k) {
      stop.row();
      const bool a_sample = samples && k < samples->times().size() && samples->times()[k] == time(k);
      const ReferencePoint point = a_sample ? samples->sample(k) : reference.at(time(k));
      if (k < kept_) {
        position_[k] = point.position;
        velocity_[k] = point.velocity;
        acceleration_[k] = point.acceleration;
      }
      numbers_ = numbers_ && point.position == point.position;
      lowest_ = std::min(lowest_, point.position);
      highest_ = std::max(highest_, point.position);
    }
  }

  std::size_t size() const { return count_; }
  double sample_rate() const { return sample_rate_; }
  const Reference& reference() const { return *reference_; }
  double time(std::size_t k) const { return static_cast<double>(k) / sample_rate_; }
  COGGING_INLINE ReferencePoint at(std::size_t k) const {
    if (k < kept_) [[likely]]
      return {position_[k], velocity_[k], acceleration_[k]};
    return reference_->at(time(k));
  }

  /// Raises std::invalid_argument, naming the first row that lies outside.
  void require_within(const Range& travel) const {
    if (numbers_ && lowest_ >= travel[0] && highest_ <= travel[1]) return;
    for (std::size_t k = 0; k < count_; ++k) {
      const double position = at(k).position;
      if (!(position >= travel[0] && position <= travel[1]))
        refuse("reference", "must stay within travel [" + format(travel[0]) + ", " + format(travel[1]) + "]",
               format(position) + " at " + format(time(k)) + " s");
    }
  }

  /// Gives away the columns that are kept: position, velocity, acceleration.
  void move_to(std::vector<double>& position, std::vector<double>& velocity, std::vector<double>& acceleration) && {
    position = std::move(position_);
    velocity = std::move(velocity_);
    acceleration = std::move(acceleration_);
  }

  /// How many rows a run has; 0 s: to the motion's own end. Raises std::invalid_argument as the constructor does.
  static std::size_t count(const Reference& reference, double duration, double sample_rate) {
    duration = length(reference, duration);
    require(std::isfinite(duration), "duration", "must be given for a reference without an end of its own", duration);
    const double samples = duration * sample_rate;
    require(samples >= 1.0 && samples < 1e9, "duration", "must hold 1 to 1e9 samples", duration);
    return whole_part<std::size_t>(std::floor(samples + 1e-6)) + 1;
  }

  /// What a duration asks for, s.
  static double length(const Reference& reference, double duration) {
    return duration > 0.0 ? duration : reference.end();
  }

 private:
  const Reference* reference_;
  double sample_rate_;
  std::size_t count_, kept_;
  std::vector<double> position_, velocity_, acceleration_;
  bool numbers_ = true;
  double lowest_ = infinity, highest_ = -infinity;
};

/// The rows of the motions of a batch, each computed once for the runs that follow it at one rate: those that were
/// asked for last are kept, for all threads.
class SharedRows {
 public:
  std::shared_ptr<const ReferenceRows> of(const Reference& reference, double duration, double sample_rate,
                                          StopRequest* stop) {
    const Key key{&reference, duration, sample_rate};
    {
      const std::lock_guard lock(mutex_);
      if (auto found = find(key)) return found;
    }
    StopCheck check(stop);  // other threads need not wait for these rows, unless they want the same
    auto made = std::make_shared<const ReferenceRows>(reference, duration, sample_rate, check);
    const std::lock_guard lock(mutex_);
    if (auto found = find(key)) return found;
    kept_.emplace_front(key, made);
    if (kept_.size() > kept_most) kept_.pop_back();
    return made;
  }

 private:
  static constexpr std::size_t kept_most = 8;
  struct Key {
    const Reference* reference = nullptr;
    double duration, sample_rate;
    bool operator==(const Key&) const = default;
  };
  using Entry = std::pair<Key, std::shared_ptr<const ReferenceRows>>;

  std::shared_ptr<const ReferenceRows> find(const Key& key) {
    const auto at = std::find_if(kept_.begin(), kept_.end(), [&](const Entry& entry) { return entry.first == key; });
    if (at == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, at);
    return at->second;
  }

  std::mutex mutex_;
  std::list<Entry> kept_;
};

}  // namespace cogging
