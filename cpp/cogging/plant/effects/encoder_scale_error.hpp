#pragma once
// An encoder whose scale is wrong.

#include "cogging/plant/effect.hpp"

namespace cogging {

/// reading = x (1 + scale), before noise and rounding.
template <class Scalar = double>
struct EncoderScaleError {
  static constexpr std::string_view name = "encoder_scale_error";
  static constexpr std::string_view law = "reading = x (1 + scale)";

  Scalar scale = 0.0;

  static constexpr auto fields() {
    return std::tuple{Field{"scale", &EncoderScaleError::scale, "1", "by which the reading is too large, relative",
                            amplitude(Quantity::relative, 0.1)}};
  }

  Scalar reading_error(const Scalar& position) const { return position * scale; }
};

}  // namespace cogging
