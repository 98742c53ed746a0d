#pragma once
// Every controller that a model file may name: one line each.

#include <variant>

#include "cogging/control/adaptive_robust.hpp"
#include "cogging/control/cascade.hpp"
#include "cogging/control/observer_based.hpp"
#include "cogging/control/output_feedback_adaptive_robust.hpp"
#include "cogging/control/pid.hpp"
#include "cogging/control/speed.hpp"

namespace cogging {

template <class Scalar = double>
using AnyController = std::variant<Pid<Scalar>,                // positions only, with feedforward
                                   Cascade<Scalar>,            // a position loop around a velocity loop
                                   Speed<Scalar>,              // a velocity loop alone
                                   Arc<Scalar>,                // adaptive robust, regressor on the measured state
                                   Dcarc<Scalar>,              // adaptive robust, regressor on the reference
                                   OutputFeedbackArc<Scalar>,  // adaptive robust, from positions only
                                   ObserverBased<Scalar>       // cancels what an observer finds
                                   >;

namespace detail {
template <class Scalar, class... C>
constexpr bool all_listed(const std::variant<C...>*) {
  return (ListedController<C, Scalar> && ...);
}
}  // namespace detail
static_assert(detail::all_listed<double>(static_cast<const AnyController<>*>(nullptr)));

}  // namespace cogging
