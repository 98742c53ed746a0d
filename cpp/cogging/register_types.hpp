#pragma once
// Doubles side by side, by the compilers' vector types (GCC, Clang): what registers.hpp computes with.

#include <cstddef>
#include <cstdint>

#if defined(__GNUC__)

namespace cogging {

// Each width by its own name: GCC does not take a size that depends on a template's argument.
template <std::size_t width>
struct RegisterTypes;
template <>
struct RegisterTypes<2> {
  using Numbers [[gnu::vector_size(16)]] = double;
  using Mask [[gnu::vector_size(16)]] = std::int64_t;
};
template <>
struct RegisterTypes<4> {
  using Numbers [[gnu::vector_size(32)]] = double;
  using Mask [[gnu::vector_size(32)]] = std::int64_t;
};
template <>
struct RegisterTypes<8> {
  using Numbers [[gnu::vector_size(64)]] = double;
  using Mask [[gnu::vector_size(64)]] = std::int64_t;
};

}  // namespace cogging

#endif
