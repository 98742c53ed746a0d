#pragma once
// The contract of every controller.

#include <concepts>
#include <cstddef>
#include <span>
#include <string_view>

#include "cogging/inlining.hpp"
#include "cogging/reference/reference.hpp"

namespace cogging {

/// A controller that looks ahead says by how much, `preview()` in s, and takes a second reference of that time.
template <class C>
concept LooksAhead = requires(const C& fixed) {
  { fixed.preview() } -> std::same_as<double>;
};

template <class C, class Scalar>
concept GivesCommand = requires(C controller, const ReferencePoint& reference, Scalar reading) {
  { controller.command(reference, reading) } -> std::same_as<Scalar>;
} || (LooksAhead<C> && requires(C controller, const ReferencePoint& reference, Scalar reading) {
                         { controller.command(reference, reference, reading) } -> std::same_as<Scalar>;
                       });

/// What a loop asks of whatever closes it. Two calls a sample: the command from reference and reading, then an update
/// with the command that was really applied. It is a value: a copy of a fresh one is a fresh one.
template <class C, class Scalar>
concept ClosesLoop =
    std::copyable<C> && GivesCommand<C, Scalar> && requires(C controller, const C& fixed, Scalar reading) {
      controller.update(reading);
      { fixed.sample_rate() } -> std::same_as<double>;
      { fixed.command_limit() } -> std::same_as<double>;  // V; 0 = none
      { fixed.estimates() } -> std::same_as<std::span<const Scalar>>;
    };

/// The command of a sample at `time` (s); `motion` is what one that looks ahead follows.
template <class Scalar, class C>
COGGING_INLINE Scalar command_at(C& controller, const Reference& motion, double time, const ReferencePoint& reference,
                                 const Scalar& reading) {
  if constexpr (LooksAhead<C>)
    return controller.command(reference, motion.at(time + controller.preview()), reading);
  else
    return controller.command(reference, reading);
}

/// One of a user's own, which may fail, is told before each sample where the run stands, so that it can say so.
template <class C>
concept MayFail = requires(C controller, std::size_t row, double time) { controller.begin_row(row, time); };

/// A controller of the core: neither call allocates, throws, locks or calls the system.
template <class C, class Scalar>
concept Controller = ClosesLoop<C, Scalar> && !MayFail<C> && requires(C controller, Scalar reading) {
  { controller.update(reading) } noexcept;
} && (requires(C controller, const ReferencePoint& reference, Scalar reading) {
                       { controller.command(reference, reading) } noexcept;
                     } || requires(C controller, const ReferencePoint& reference, Scalar reading) {
                       { controller.command(reference, reference, reading) } noexcept;
                     });

/// One that model files name: each stands in one file and in one line of list.hpp.
template <class C, class Scalar>
concept ListedController =
    Controller<C, Scalar> && std::constructible_from<C, const typename C::Parameters&> && requires(const C& fixed) {
      { C::name } -> std::convertible_to<std::string_view>;         // as model files write it
      { C::description } -> std::convertible_to<std::string_view>;  // a sentence, then the law
      { fixed.parameters() } -> std::same_as<const typename C::Parameters&>;
      { fixed.samples_refused() } -> std::same_as<const Scalar&>;
    };

}  // namespace cogging
