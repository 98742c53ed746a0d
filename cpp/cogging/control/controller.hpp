#pragma once
// The contract of every controller.

#include <concepts>
#include <span>

#include "cogging/reference/reference.hpp"

namespace cogging {

/// A controller that looks ahead says by how much, `preview()` in s, and takes a second reference of that time.
template <class C>
concept LooksAhead = requires(const C& fixed) {
  { fixed.preview() } -> std::same_as<double>;
};

template <class C, class Scalar>
concept GivesCommand = requires(C controller, const ReferencePoint& reference, Scalar reading) {
  { controller.command(reference, reading) } noexcept -> std::same_as<Scalar>;
} || (LooksAhead<C> && requires(C controller, const ReferencePoint& reference, Scalar reading) {
                         { controller.command(reference, reference, reading) } noexcept -> std::same_as<Scalar>;
                       });

/// Two calls a sample: the command from reference and reading, then an update with the command that was
/// really applied. Neither allocates, throws, locks or calls the system. A controller is a value: a copy of a
/// fresh one is a fresh one.
template <class C, class Scalar>
concept Controller =
    std::copyable<C> && GivesCommand<C, Scalar> && requires(C controller, const C& fixed, Scalar reading) {
      { controller.update(reading) } noexcept;
      { fixed.sample_rate() } -> std::same_as<double>;
      { fixed.command_limit() } -> std::same_as<double>;  // V; 0 = none
      { fixed.estimates() } -> std::same_as<std::span<const Scalar>>;
    };

}  // namespace cogging
