#pragma once
// Which runs may share the lanes of a pack, and structs of one machine packed into structs of many.

#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "cogging/control/list.hpp"
#include "cogging/lanes.hpp"
#include "cogging/parameters.hpp"
#include "cogging/plant/plant.hpp"

namespace cogging {

namespace detail {

template <class Struct, class Member>
Member member(const Field<Struct, Member>&);

/// Calls visit(field of the struct of one machine, that of the struct of many, whether they are of one type).
template <class One, class Many, class Visitor>
void for_each_pair(const Visitor& visit) {
  constexpr auto ones = One::fields();
  constexpr auto packs = Many::fields();
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (visit(std::get<i>(ones), std::get<i>(packs),
           std::is_same<decltype(member(std::get<i>(ones))), decltype(member(std::get<i>(packs)))>{}),
     ...);
  }(std::make_index_sequence<std::tuple_size_v<decltype(One::fields())>>());
}

/// Calls visit<place>() with the place of the alternative that the variant holds.
template <class Variant, class Visitor>
void at_place(const Variant& variant, const Visitor& visit) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    ((variant.index() == i ? visit.template operator()<i>() : void()), ...);
  }(std::make_index_sequence<std::variant_size_v<Variant>>());
}

template <class E>
concept HasFields = requires { E::fields(); };

using AnyLanes = Lanes<register_width>;

/// Whether the axis sticks, or something else of it has a memory, or asks a function of somebody's own.
inline bool runs_alone(const Plant<double>& plant) {
  bool alone = false, rubs = plant.axis.coulomb != 0.0;
  for (const Effect<double>& effect : plant.effects)
    std::visit(
        [&]<class E>(const E& law) {
          if constexpr (!HasFields<E>) alone = true;
          if constexpr (HasBristle<E>) alone = alone || law.bristle().exists();
          if constexpr (HasCoupling<E>) alone = alone || !law.coupling().rigid();
          if constexpr (HasFrictionLevel<E, double>) rubs = true;
        },
        effect);
  return alone || (rubs && !(plant.axis.coulomb_width > 0.0));
}

}  // namespace detail

/// The struct of many machines from those of each; what has no lanes in it is that of the first.
template <class Many, class One, std::size_t count>
Many packed(const std::array<const One*, count>& ones) {
  Many result{};
  detail::for_each_pair<One, Many>([&](const auto& single, const auto& pack, auto same) {
    if constexpr (same)
      result.*(pack.member) = ones[0]->*(single.member);
    else
      result.*(pack.member) = Lanes<count>::map([&](std::size_t i) { return ones[i]->*(single.member); });
  });
  return result;
}

/// What the runs of a pack have in common, as bytes: runs with the same text share a course.
class SharedCourse {
 public:
  template <class Value>
  void add(const Value& value) {
    if constexpr (std::is_arithmetic_v<Value>) {
      char bytes[sizeof(Value)];
      std::memcpy(bytes, &value, sizeof(Value));
      text_.append(bytes, sizeof(Value));
    } else {
      add(std::size(value));
      for (const auto& entry : value) add(entry);
    }
  }

  /// What a pack of such structs says but once.
  template <class Many, class One>
  void add_shared(const One& one) {
    detail::for_each_pair<One, Many>([&](const auto& single, const auto&, auto same) {
      if constexpr (same) add(one.*(single.member));
    });
  }

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// What the forces of plants have in common that share a pack, none where one must stand alone.
inline std::optional<SharedCourse> course_of_forces(const Plant<double>& plant) {
  using detail::AnyLanes;
  if (detail::runs_alone(plant)) return std::nullopt;
  SharedCourse course;
  course.add_shared<AxisParameters<AnyLanes>>(plant.axis);
  const SplineHarmonics& basis = plant.cogging.basis();
  course.add(basis.pitch()), course.add(basis.harmonics()), course.add(basis.periods());
  const BSpline& spline = basis.spline();
  course.add(spline.order()), course.add(spline.origin()), course.add(spline.pitch());
  course.add(spline.control_points());
  for (const Effect<double>& effect : plant.effects)
    detail::at_place(effect, [&]<std::size_t kind>() {
      using One = std::variant_alternative_t<kind, Effect<double>>;
      course.add(kind);
      if constexpr (detail::HasFields<One>)
        course.add_shared<std::variant_alternative_t<kind, Effect<AnyLanes>>>(std::get<kind>(effect));
    });
  return course;
}

/// The course of a run, none where it must run alone. The controller is one of AnyController, as it was made: a pack
/// knows no past.
template <std::size_t place>
std::optional<SharedCourse> course_of(const Plant<double>& plant,
                                      const std::variant_alternative_t<place, AnyController<>>& controller) {
  std::optional<SharedCourse> course = course_of_forces(plant);
  if (!course) return course;
  course->add(place);
  course->add_shared<typename std::variant_alternative_t<place, AnyController<detail::AnyLanes>>::Parameters>(
      controller.parameters());
  const double sample_time = 1.0 / controller.sample_rate();
  for_each_law(plant.effects, [&](const HasLag auto& law) {  // steps are cut where one settles within them
    const double time_constant = law.lag_time_constant();
    course->add(time_constant < 1.001 * sample_time ? time_constant : sample_time);
  });
  course->add(plant.encoder.resolution > 0.0);
  return course;
}

/// The plants of a pack, all of one course.
template <std::size_t count>
Plant<Lanes<count>> packed_plant(const std::array<const Plant<double>*, count>& plants) {
  using Scalar = Lanes<count>;
  const auto each = [&](const auto& part) {
    std::array<decltype(part(*plants[0])), count> parts{};
    for (std::size_t i = 0; i < count; ++i) parts[i] = part(*plants[i]);
    return parts;
  };
  Plant<Scalar> result;
  result.axis = packed<AxisParameters<Scalar>>(each([](const Plant<double>& p) { return &p.axis; }));
  const std::size_t coefficients = plants[0]->cogging.coefficients().size();
  std::vector<Scalar> amplitudes;
  for (std::size_t c = 0; c < coefficients; ++c)
    amplitudes.push_back(Scalar::map([&](std::size_t i) { return plants[i]->cogging.coefficients()[c]; }));
  if (coefficients > 0) result.cogging = CoggingModel<Scalar>(plants[0]->cogging.basis(), std::move(amplitudes));
  for (std::size_t e = 0; e < plants[0]->effects.size(); ++e)
    detail::at_place(plants[0]->effects[e], [&]<std::size_t place>() {
      using One = std::variant_alternative_t<place, Effect<double>>;
      using Many = std::variant_alternative_t<place, Effect<Scalar>>;
      if constexpr (detail::HasFields<One>)
        result.effects.push_back(
            packed<Many>(each([e](const Plant<double>& p) { return &std::get<place>(p.effects[e]); })));
    });
  return result;
}

}  // namespace cogging
