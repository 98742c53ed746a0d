#pragma once
// B-splines of any order on uniform knots (Lu et al. 2008, eq. 6 and Figs. 1 to 3).

#include <array>
#include <type_traits>

#include "cogging/require.hpp"
#include "cogging/scalar.hpp"

namespace cogging {

/// Uniform B-spline basis of order k (k = 1: piecewise constant) with m control points.
///
/// Control point c (from 0) acts on [origin + (c + 1 - k) pitch, origin + (c + 1) pitch). The m - k + 1 spans
/// between origin and end() carry k control points each, where the basis sums to one. Outside of them a
/// spline keeps its end value (so it is continuous and its slope is zero). One control point is a constant.
class BSpline {
 public:
  static constexpr int order_max = 16;

  /// The control points that act at a position, and their weights.
  template <class Scalar>
  struct Active {
    typename IndexOf<Scalar>::type first;
    std::array<Scalar, order_max> weight;
  };

  BSpline() : BSpline(1, 0.0, 1.0, 1) {}

  BSpline(int order, double origin, double pitch, int control_points)
      : order_(control_points == 1 ? 1 : order),
        control_points_(control_points),
        origin_(origin),
        pitch_(pitch),
        inverse_pitch_(1.0 / pitch) {
    require(order >= 1 && order <= order_max, "order", "must be from 1 to 16", order);
    require_finite("origin", origin);
    require_positive("pitch", pitch);
    require(control_points >= 1, "control_points", "must be at least 1", control_points);
    if (control_points > 1)
      require(control_points >= order, "control_points", "more than one must be at least the order " + format(order),
              control_points);
  }

  int order() const { return order_; }
  int control_points() const { return control_points_; }
  int spans() const { return control_points_ - order_ + 1; }
  double origin() const { return origin_; }
  double pitch() const { return pitch_; }
  double end() const { return origin_ + spans() * pitch_; }
  bool constant() const { return control_points_ == 1; }

  /// function(order), with the usual orders as constants: loops over the active control points then unroll.
  template <class Function>
  COGGING_INLINE decltype(auto) with_order(const Function& function) const {
    if (order_ == 1) return function(std::integral_constant<int, 1>{});
    if (order_ == 2) return function(std::integral_constant<int, 2>{});
    if (order_ == 3) return function(std::integral_constant<int, 3>{});
    if (order_ == 4) return function(std::integral_constant<int, 4>{});
    return function(order_);
  }

  template <class Scalar>
  COGGING_INLINE void evaluate(const Scalar& position, Active<Scalar>& active) const {
    with_order([&](auto order) COGGING_INLINE_LAMBDA { evaluate(order, position, active); });
  }

  /// The same within with_order.
  template <class Order, class Scalar>
  COGGING_INLINE void evaluate(Order order, const Scalar& position, Active<Scalar>& active) const {
    if (constant()) {
      active.first = {};
      active.weight[0] = 1.0;
      return;
    }
    const Scalar t = locate(position, active.first);
    fill(order, t, active.weight);
  }

  /// Also the slope of each weight, in 1/m.
  template <class Scalar>
  void evaluate(const Scalar& position, Active<Scalar>& active, std::array<Scalar, order_max>& slope) const {
    evaluate(position, active);
    slope[0] = 0.0;
    if (constant() || order_ == 1) return;
    typename IndexOf<Scalar>::type first;
    const Scalar t = locate(position, first);
    std::array<Scalar, order_max> lower;
    fill(order_ - 1, t, lower);
    // d N_{c,k}/dx = (N_{c,k-1} - N_{c+1,k-1}) / pitch on uniform knots.
    const auto inside = [&](const Scalar& value) {
      return select(position < origin_, Scalar(0.0), select(position >= end(), Scalar(0.0), value));
    };
    for (int j = 0; j < order_; ++j) {
      const Scalar before = j > 0 ? lower[j - 1] : Scalar(0.0);
      const Scalar here = j < order_ - 1 ? lower[j] : Scalar(0.0);
      slope[j] = inside((before - here) * inverse_pitch_);
    }
  }

 private:
  template <class Scalar>
  COGGING_INLINE Scalar locate(const Scalar& position, typename IndexOf<Scalar>::type& span) const {
    // Clamped before it becomes an integer: a position far outside must not overflow.
    const Scalar u = clamp((position - origin_) * inverse_pitch_, Scalar(0.0), Scalar(spans()));
    span = truncate_to_index(u, spans() - 1);
    return u - from_index(span);
  }

  // The Cox-de Boor recursion for knots one unit apart, t in [0, 1].
  template <class Order, class Scalar>
  COGGING_INLINE static void fill(Order order, const Scalar& t, std::array<Scalar, order_max>& weight) {
    weight[0] = 1.0;
    if (order == 1) return;
    weight[0] = 1.0 - t;
    weight[1] = t;
    for (int d = 2; d < order; ++d) {
      Scalar saved = 0.0;
      for (int r = 0; r < d; ++r) {
        const Scalar part = weight[r] * reciprocal[d];
        const Scalar falling = (double(r + 1) - t) * part;
        weight[r] = r == 0 ? falling : saved + falling;
        saved = (t + double(d - r - 1)) * part;
      }
      weight[d] = saved;
    }
  }

  static constexpr std::array<double, order_max> reciprocal = [] {
    std::array<double, order_max> values{};
    for (int d = 1; d < order_max; ++d) values[d] = 1.0 / d;
    return values;
  }();

  int order_;
  int control_points_;
  double origin_;
  double pitch_;
  double inverse_pitch_;
};

}  // namespace cogging
