#pragma once
// The rows of the motions of a batch, each computed once for the runs that follow it at one rate.

#include <algorithm>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>

#include "cogging/simulation/reference_rows.hpp"

namespace cogging {

/// Keeps those that were asked for last, for all threads of a batch.
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
    kept_.push_front({key, made});
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
  struct Entry {
    Key key;
    std::shared_ptr<const ReferenceRows> rows;
  };

  std::shared_ptr<const ReferenceRows> find(const Key& key) {
    const auto at = std::find_if(kept_.begin(), kept_.end(), [&](const Entry& entry) { return entry.key == key; });
    if (at == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, at);
    return at->rows;
  }

  std::mutex mutex_;
  std::list<Entry> kept_;
};

}  // namespace cogging
