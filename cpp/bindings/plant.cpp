#include "cogging/plant/plant.hpp"
#include "bindings.hpp"
#include "cogging/plant/amplifier.hpp"

using namespace cogging;

namespace {

// constant_force -> ConstantForce
std::string class_name(std::string_view name) {
  std::string result;
  bool start = true;
  for (char letter : name) {
    if (letter == '_') {
      start = true;
      continue;
    }
    result += start ? static_cast<char>(letter - 'a' + 'A') : letter;
    start = false;
  }
  return result;
}

template <class E>
void bind_effect(py::module_& module, py::dict& effects) {
  const std::string doc = "Effect `" + std::string(E::name) + "`: " + std::string(E::law) + ".";
  auto bound = bind_parameters<E>(module, class_name(E::name), doc);
  bound.attr("NAME") = std::string(E::name);
  bound.attr("LAW") = std::string(E::law);
  if constexpr (HasForce<E, double>)
    bound.def(
        "force_at",
        [](const E& effect, double position, double velocity, double time) {
          return effect.force(Motion<double>{position, velocity, sign(velocity), time});
        },
        py::kw_only(), py::arg("position") = 0.0, py::arg("velocity") = 0.0, py::arg("time") = 0.0,
        "Force (V) at a position (m), velocity (m/s) and time (s).");
  if constexpr (HasFrictionLevel<E, double>)
    bound.def(
        "friction_level_at",
        [](const E& effect, double position, double velocity, double time) {
          return effect.friction_level(Motion<double>{position, velocity, sign(velocity), time});
        },
        py::kw_only(), py::arg("position") = 0.0, py::arg("velocity") = 0.0, py::arg("time") = 0.0,
        "Level (V) that it adds to Fc at a position (m), velocity (m/s) and time (s).");
  effects[py::str(std::string(E::name))] = bound;
}

template <class... E>
void bind_effects(py::module_& module, py::dict& effects, const std::variant<E...>*) {
  (bind_effect<E>(module, effects), ...);
}

template <class E>
void validate_effects(const std::vector<E>& effects) {
  for (const E& effect : effects) std::visit([](const auto& law) { law.validate(); }, effect);
}

}  // namespace

void bind_plant(py::module_& module) {
  bind_parameters<AxisParameters<>>(module, "AxisParameters",
                                    "Mass and friction of the axis: M x'' = u - B x' - Fc S(x') - "
                                    "F_cogging(x) + effects (Lu et al. 2008, eq. 1, 2).");
  bind_parameters<EncoderParameters>(module, "EncoderParameters",
                                     "reading = resolution round((x + noise) / resolution).");
  bind_parameters<NoiseParameters>(module, "NoiseParameters",
                                   "Force noise of a first-order spectrum, held between samples.");
  py::module_ submodule = module.def_submodule("effects", "Every effect that a plant may have, one class each.");
  py::dict effects;
  bind_effects(submodule, effects, static_cast<const Effect<>*>(nullptr));
  module.attr("EFFECTS") = effects;

  py::class_<Plant<>>(module, "Plant", R"(A whole machine: axis, cogging, effects, encoder and noise.

Raises:
    ValueError: more than one actuator_lag among the effects.)")
      .def(py::init([](const AxisParameters<>& axis, const std::optional<CoggingModel<>>& cogging,
                       const std::vector<Effect<>>& list, const EncoderParameters& encoder,
                       const NoiseParameters& noise) {
             validate_effects(list);
             Amplifier<double>(list, 1.0);  // refuses a list that no amplifier can have
             return Plant<>{axis, cogging.value_or(CoggingModel<>()), list, encoder, noise};
           }),
           py::arg("axis"), py::kw_only(), py::arg("cogging") = py::none(), py::arg("effects") = py::list(),
           py::arg("encoder") = EncoderParameters{}, py::arg("noise") = NoiseParameters{})
      .def_property_readonly("axis", [](const Plant<>& plant) { return plant.axis; })
      .def_property_readonly("cogging",
                             [](const Plant<>& plant) {
                               return plant.cogging.basis().empty() ? std::nullopt : std::optional(plant.cogging);
                             })
      .def_property_readonly("effects", [](const Plant<>& plant) { return plant.effects; })
      .def_property_readonly("encoder", [](const Plant<>& plant) { return plant.encoder; })
      .def_property_readonly("noise", [](const Plant<>& plant) { return plant.noise; })
      .def(
          "acceleration",
          [](const Plant<>& plant, double position, double velocity, double command, double time) {
            return Axis<>(plant.axis, plant.cogging, plant.effects).acceleration(position, velocity, command, time);
          },
          py::kw_only(), py::arg("position"), py::arg("velocity"), py::arg("command"), py::arg("time") = 0.0,
          "Acceleration (m/s^2) of the moving axis when `command` (V) acts: the amplifier's effects are not "
          "in it.");
}
