#pragma once
// The contract of every controller.

#include <concepts>
#include <span>

#include "cogging/reference/reference.hpp"

namespace cogging {

/// Two calls a sample: the command from reference and reading, then an update with the command that was
/// really applied. Neither allocates, throws, locks or calls the system. A controller is a value: a copy of a
/// fresh one is a fresh one.
template <class C, class Scalar>
concept Controller =
    std::copyable<C> && requires(C controller, const C& fixed, const ReferencePoint& reference, Scalar reading) {
      { controller.command(reference, reading) } noexcept -> std::same_as<Scalar>;
      { controller.update(reading) } noexcept;
      { fixed.sample_rate() } -> std::same_as<double>;
      { fixed.command_limit() } -> std::same_as<double>;  // V; 0 = none
      { fixed.estimates() } -> std::same_as<std::span<const Scalar>>;
    };

}  // namespace cogging
