#include "cogging/plant/plant.hpp"
#include "bindings.hpp"
#include "cogging/plant/amplifier.hpp"
#include "instantiated.hpp"
#include "own_effect.hpp"

using namespace cogging;

namespace {

// Which of the plant's questions it answers.
template <class E>
py::tuple hooks_of() {
  py::list hooks;
  const auto add = [&](bool has, const char* name) {
    if (has) hooks.append(name);
  };
  add(HasForce<E, double>, "force");
  add(HasFrictionLevel<E, double>, "friction_level");
  add(HasCommandGain<E, double>, "command_gain");
  add(HasShapeCommand<E, double>, "shape_command");
  add(HasCommandDelay<E>, "command_delay");
  add(HasLag<E>, "lag");
  add(HasReading<E, double>, "reading");
  add(HasBristle<E> || HasCoupling<E>, "state");
  return py::tuple(hooks);
}

py::dict roles_of(const BoundStruct& effect) {
  py::dict roles;
  for (const BoundField& field : effect.fields) {
    const Trait& trait = field.trait;
    py::dict role;
    const bool searched = trait.role != Role::setting;
    role["role"] = std::string(to_string(trait.role));
    role["quantity"] = std::string(to_string(trait.quantity));
    role["low"] = searched ? py::object(py::float_(trait.low)) : py::none();
    role["high"] = searched ? py::object(py::float_(trait.high)) : py::none();
    role["logarithmic"] = trait.logarithmic;
    role["neutral"] = trait.vanishes ? field.usual : py::none();
    roles[py::str(field.name)] = role;
  }
  return roles;
}

template <class E>
py::tuple kinds_of() {
  py::list kinds;
  if constexpr (HasKinds<E>)
    for (const Kind& kind : E::kinds()) kinds.append(py::cast(kind));
  return py::tuple(kinds);
}

// The effect in a plant, or by itself where there is none.
template <class E>
E resolved(E effect, const PlantContext& plant = {}) {
  if constexpr (HasBind<E>) effect.bind(plant);
  return effect;
}

using Values = py::array_t<double, py::array::forcecast>;
using Law = std::function<double(double, double, double)>;

// Of a law that does not ask for it.
Values nothing() {
  return Values(py::float_(0.0));
}

// A law at positions, velocities and times.
py::object along(const Law& law, const Values& position, const Values& velocity, const Values& time) {
  return py::vectorize(law)(position, velocity, time);
}

template <class E>
void bind_laws(py::class_<E>& bound) {
  const auto by_motion = [&](const char* name, auto law, const char* doc) {
    bound.def(
        name,
        [law](const E& effect, const Values& position, const Values& velocity, const Values& time) {
          const E made = resolved(effect);
          return along([&](double x, double v, double t) { return law(made, Motion<double>{x, v, sign(v), t}); },
                       position, velocity, time);
        },
        py::kw_only(), py::arg("position") = 0.0, py::arg("velocity") = 0.0, py::arg("time") = 0.0, doc);
  };
  if constexpr (HasForce<E, double>)
    by_motion(
        "force_at", [](const E& effect, const Motion<double>& motion) { return effect.force(motion); },
        "Force (V) at positions (m), velocities (m/s) and times (s).");
  if constexpr (HasFrictionLevel<E, double>)
    by_motion(
        "friction_level_at",
        [](const E& effect, const Motion<double>& motion) { return effect.friction_level(motion); },
        "Level (V) that it adds to Fc at positions (m), velocities (m/s) and times (s).");
  if constexpr (HasCommandGain<E, double>)
    bound.def(
        "gain_at",
        [](const E& effect, const Values& position, const Values& time) {
          return along([&](double x, double, double t) { return effect.command_gain(x, t); }, position, nothing(),
                       time);
        },
        py::kw_only(), py::arg("position") = 0.0, py::arg("time") = 0.0,
        "What it adds to the gain 1 of the command (relative) at positions (m) and times (s).");
  if constexpr (HasShapeCommand<E, double>)
    bound.def(
        "shape_at",
        [](const E& effect, const Values& command) {
          return along([&](double u, double, double) { return effect.shape_command(u); }, command, nothing(),
                       nothing());
        },
        py::arg("command"), "What the amplifier makes of commands, V.");
  if constexpr (HasReading<E, double>)
    bound.def(
        "reading_at",
        [](const E& effect, const Values& position) {
          return along([&](double x, double, double) { return x + effect.reading_error(x); }, position, nothing(),
                       nothing());
        },
        py::arg("position"), "What the encoder reads at positions, m, before noise and rounding.");
}

template <class E>
void bind_listed(py::module_& module, py::dict& effects) {
  const std::string doc = "Effect `" + std::string(E::name) + "`: " + std::string(E::law) + ".";
  const BoundStruct fields = bound_struct<E>();
  auto bound = bind_parameters<E>(module, class_name(E::name), doc, fields);
  bound.attr("NAME") = std::string(E::name);
  bound.attr("LAW") = std::string(E::law);
  bound.attr("HOOKS") = hooks_of<E>();
  bound.attr("ROLES") = roles_of(fields);
  bound.attr("KINDS") = kinds_of<E>();
  bind_laws<E>(bound);
  bound.def(
      "resolved",
      [](const E& effect, const AxisParameters<>& axis, const std::optional<CoggingModel<>>& cogging) {
        return resolved(effect, context_of(axis, cogging.value_or(CoggingModel<>())));
      },
      py::arg("axis"), py::arg("cogging") = py::none(),
      "A copy whose fields that stand for those of the plant (travel, knots) are filled in.\n\n"
      "Raises:\n    ValueError: the plant lacks what it needs.");
  effects[py::str(std::string(E::name))] = bound;
}

template <class E>
void bind_effect(py::module_& module, py::dict& effects) {
  if constexpr (!ChoosesHooks<E>)
    bind_listed<E>(module, effects);  // of others each says itself what it is: own_effect.cpp
}

template <class... E>
void bind_effects(py::module_& module, py::dict& effects, const std::variant<E...>*) {
  (bind_effect<E>(module, effects), ...);
}

}  // namespace

void bind_plant(py::module_& module) {
  module.def("smooth_sign", py::vectorize([](double velocity, double width) { return smooth_sign(velocity, width); }),
             py::arg("velocity"), py::arg("width"),
             "S(v) = (2/pi) atan(v / width), v and width in m/s; width = 0 is sgn(v), with sgn(0) = 0.");
  bind_parameters<AxisParameters<>>(module, "AxisParameters",
                                    "Mass and friction of the axis: M x'' = u - B x' - Fc S(x') - "
                                    "F_cogging(x) + effects (Lu et al. 2008, eq. 1, 2).");
  bind_parameters<EncoderParameters>(module, "EncoderParameters",
                                     "reading = resolution round((x + errors + noise) / resolution).");
  bind_parameters<NoiseParameters>(module, "NoiseParameters",
                                   "Force noise of a first-order spectrum, held between samples.");
  py::module_ submodule = module.def_submodule("effects", "Every effect that a plant may have, one class each.");
  bind_parameters<Wave>(submodule, "Wave", "A sine and a cosine of one period; the names of their fields.");
  bind_parameters<Window>(submodule, "Window", "A stretch of time; the names of its fields.");
  bind_parameters<Knots>(submodule, "Knots", "Values at nodes, linear between two; the names of their fields.");
  bind_parameters<SplineKnots>(submodule, "SplineKnots",
                               "Even knots of B-splines whose control points are the lists of amplitudes; the names of "
                               "their fields.");
  bind_parameters<Travel>(submodule, "Travel",
                          "The ends of the travel, of the plant where not given; the field's name.");
  bind_parameters<Place>(submodule, "Place", "A stretch of the travel about a place; the names of its fields.");
  bind_parameters<Turn>(submodule, "Turn", "A wave of exactly one turn of a rotary axis; the field's name.");
  bind_own_effect(submodule);
  py::dict effects;
  bind_effects(submodule, effects, static_cast<const Effect<>*>(nullptr));
  module.attr("EFFECTS") = effects;

  py::class_<Plant<>>(module, "Plant", R"(A whole machine: axis, cogging, effects, encoder and noise.

Raises:
    ValueError: more than one actuator_lag, presliding_friction, or load (backlash, flexible_mode) among the effects;
        an effect that needs the travel or the knots of the cogging where there are none.

Example:
    >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.1), effects=[cogging.effects.ConstantForce(force=0.5)])
    >>> plant.acceleration(position=0.0, velocity=0.0, command=1.0)
    15.0)")
      .def(py::init([](const AxisParameters<>& axis, const std::optional<CoggingModel<>>& cogging,
                       const std::vector<Effect<>>& list, const EncoderParameters& encoder,
                       const NoiseParameters& noise) {
             Amplifier<double>(list, 1.0);  // refuses a list that no amplifier can have
             const CoggingModel<> model = cogging.value_or(CoggingModel<>());
             const Axis<> refuses(axis, model, list);  // a list that no axis can have
             return Plant<>{axis, model, list, encoder, noise};
           }),
           py::arg("axis"), py::kw_only(), py::arg("cogging") = py::none(), py::arg("effects") = py::list(),
           py::arg_v("encoder", EncoderParameters{}, "cogging._core.EncoderParameters()"),
           py::arg_v("noise", NoiseParameters{}, "cogging._core.NoiseParameters()"))
      .def_property_readonly("axis", [](const Plant<>& plant) { return plant.axis; })
      .def_property_readonly("cogging",
                             [](const Plant<>& plant) {
                               return plant.cogging.basis().empty() ? std::nullopt : std::optional(plant.cogging);
                             })
      .def_property_readonly("effects",
                             [](const Plant<>& plant) {
                               py::list originals;
                               for (const Effect<>& effect : plant.effects) originals.append(original_of(effect));
                               return originals;
                             })
      .def_property_readonly("encoder", [](const Plant<>& plant) { return plant.encoder; })
      .def_property_readonly("noise", [](const Plant<>& plant) { return plant.noise; })
      .def(
          "acceleration",
          [](const Plant<>& plant, double position, double velocity, double command, double time) {
            return Axis<>(plant.axis, plant.cogging, plant.effects).acceleration(position, velocity, command, time);
          },
          py::kw_only(), py::arg("position"), py::arg("velocity"), py::arg("command"), py::arg("time") = 0.0,
          "Acceleration (m/s^2) of the moving axis when `command` (V) acts: shape, delay and lag of the amplifier are "
          "not in it, nor are states (a bristle, a load of its own).");
}
