#pragma once
// A known harmonic of the cogging whose amplitude changes along the travel.

#include "cogging/basis/spline_harmonics.hpp"
#include "cogging/plant/effect.hpp"

namespace cogging {

/// -(S(x) sin(2 pi x / period) + C(x) cos(2 pi x / period)), V; S and C are B-splines with the amplitudes `sine`
/// and `cosine`, one a control point (one alone: a constant).
///
/// Control point c acts on [origin + (c + 1 - order) pitch, origin + (c + 1) pitch). With pitch = 0 pitch, order
/// and origin are those of [cogging], and the control points as many as there. Where its amplitudes are constant
/// it has no knots: then its pitch, order 3, and the last multiple of the pitch at or below the lower end of the
/// travel (0 without one) as origin.
template <class Scalar = double>
struct CoggingModulation {
  static constexpr std::string_view name = "cogging_modulation";
  static constexpr std::string_view law = "-(S(x) sin(2 pi x / period) + C(x) cos(2 pi x / period))";

  double period = 0.01;        // m
  std::vector<double> sine;    // V
  std::vector<double> cosine;  // V
  double pitch = 0.0;          // m
  int order = 3;
  double origin = 0.0;  // m

  static constexpr auto fields() {
    using E = CoggingModulation;
    return std::tuple{
        Field{"period", &E::period, "m", "in position", Rule::period,
              logarithmic_shape(Quantity::distance, 0.002, 1.0)},
        Field{"sine", &E::sine, "V", "amplitude of the sine at each control point", amplitude(Quantity::force)},
        Field{"cosine", &E::cosine, "V", "amplitude of the cosine at each control point", amplitude(Quantity::force)},
        Field{"pitch", &E::pitch, "m", "distance of the knots; 0 = the knots of [cogging]", Rule::not_negative},
        Field{"order", &E::order, "1", "of the B-splines"},
        Field{"origin", &E::origin, "m", "first knot of the first full span"}};
  }
  static Kinds kinds() { return {Wave{"period", "sine", "cosine"}, SplineKnots{"pitch", "order", "origin"}}; }
  void validate() const {
    require(sine.size() == cosine.size(), "cosine", "must have as many values as sine = " + format(sine.size()),
            cosine.size());
    require(order >= 1 && order <= BSpline::order_max, "order", "must be from 1 to 16", order);
    if (pitch > 0.0) require_points(order);
  }

  void bind(const PlantContext& plant) {
    if (sine.empty()) return;
    if (pitch == 0.0) {
      require(plant.has_knots, "cogging_modulation.pitch", "must be given where there is no [cogging]", pitch);
      pitch = plant.knots.pitch();
      if (plant.knots.constant()) {
        order = 3;
        origin = std::isfinite(plant.travel[0]) ? std::floor(plant.travel[0] / pitch) * pitch : 0.0;
        require_points(order);
      } else {
        order = plant.knots.order();
        origin = plant.knots.origin();
        require(std::ssize(sine) == plant.knots.control_points(), "cogging_modulation.sine",
                "must have one value a control point of [cogging] = " + format(plant.knots.control_points()),
                sine.size());
      }
    }
    std::vector<Scalar> amplitudes;
    for (std::size_t c = 0; c < sine.size(); ++c) {
      amplitudes.push_back(sine[c]);
      amplitudes.push_back(cosine[c]);
    }
    const BSpline knots(order, origin, pitch, static_cast<int>(sine.size()));
    model_ = CoggingModel<Scalar>(SplineHarmonics::of_periods({period}, knots), std::move(amplitudes));
  }

  Scalar force(const Motion<Scalar>& motion) const { return -model_.force(motion.position); }

  std::vector<double> kinks() const { return model_.kinks(); }

  Variation variation() const {
    if (model_.basis().empty()) return {};
    const auto wave = model_.waves().front();
    return {.force = wave.amplitude, .wavenumber = wave.wavenumber};
  }

 private:
  void require_points(int least) const {
    require(sine.size() <= 1 || std::ssize(sine) >= least, "sine",
            "more than one value must be at least the order = " + format(least), sine.size());
  }

  CoggingModel<Scalar> model_;  // what bind() makes of the fields
};

}  // namespace cogging
