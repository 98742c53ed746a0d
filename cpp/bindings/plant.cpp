#include "cogging/plant/plant.hpp"

#include "bound_class.hpp"
#include "cogging/plant/amplifier.hpp"
#include "instantiated.hpp"

using namespace cogging;

/// An effect of a plant as Python knows it (own_effect.cpp).
py::object original_of(const Effect<>& effect);

namespace {

using Values = py::array_t<double, py::array::forcecast>;

// One law of an effect, whatever its type: of a position (or of a command), a velocity and a time.
using Law = double (*)(const void* effect, double position, double velocity, double time);

// An effect of the list, whatever its type.
struct ListedEffect {
  std::string name, law;
  BoundStruct parameters;
  py::object (*resolved)(const void* effect, const PlantContext& plant);  // a copy that knows the plant
  Kinds kinds{};
  std::vector<std::pair<std::string, Law>> hooks{};  // the plant's questions that it answers; null where at no place
};

template <class E>
ListedEffect listed_effect() {
  ListedEffect effect{std::string(E::name), std::string(E::law), bound_struct<E>(),
                      [](const void* given, const PlantContext& plant) {
                        E made = object_at<E>(given);
                        if constexpr (HasBind<E>) made.bind(plant);
                        return py::cast(std::move(made));
                      }};
  if constexpr (HasKinds<E>) effect.kinds = E::kinds();
  const auto answers = [&](const char* hook, Law law = nullptr) { effect.hooks.emplace_back(hook, law); };
  if constexpr (HasForce<E, double>)
    answers("force", [](const void* e, double x, double v, double t) -> double {
      return object_at<E>(e).force(Motion<double>{x, v, sign(v), t});
    });
  if constexpr (HasFrictionLevel<E, double>)
    answers("friction_level", [](const void* e, double x, double v, double t) -> double {
      return object_at<E>(e).friction_level(Motion<double>{x, v, sign(v), t});
    });
  if constexpr (HasCommandGain<E, double>)
    answers("command_gain",
            [](const void* e, double x, double, double t) -> double { return object_at<E>(e).command_gain(x, t); });
  if constexpr (HasShapeCommand<E, double>)
    answers("shape_command", [](const void* e, double command, double, double) -> double {
      return object_at<E>(e).shape_command(command);
    });
  if constexpr (HasCommandDelay<E>) answers("command_delay");
  if constexpr (HasLag<E>) answers("lag");
  if constexpr (HasReading<E, double>)
    answers("reading",
            [](const void* e, double x, double, double) -> double { return x + object_at<E>(e).reading_error(x); });
  if constexpr (HasState<E>) answers("state");
  return effect;
}

py::dict roles_of(const BoundStruct& effect) {
  py::dict roles;
  for (const BoundField& field : effect.fields) {
    const Trait& trait = field.trait;
    py::dict role;
    const bool searched = trait.role != Role::setting;
    role["role"] = std::string(trait.role);
    role["quantity"] = std::string(trait.quantity);
    role["low"] = searched ? py::object(py::float_(trait.low)) : py::none();
    role["high"] = searched ? py::object(py::float_(trait.high)) : py::none();
    role["logarithmic"] = trait.logarithmic;
    role["neutral"] = trait.vanishes ? field.usual : py::none();
    roles[py::str(field.name)] = role;
  }
  return roles;
}

// The methods of a class of effects: its laws at arrays, and `resolved`.
void bind_laws(const py::object& type, const ListedEffect& effect) {
  const BoundClass bound(type);
  const auto resolved = effect.resolved;
  const auto along = [bound, resolved](const Self& self, Law law, const Values& position, const Values& velocity,
                                       const Values& time) -> py::object {
    const py::object made = resolved(bound.data_of(self), {});
    const void* const data = made.cast<Self>().data;
    const auto at = [=](double x, double v, double t) { return law(data, x, v, t); };
    return py::vectorize(at)(position, velocity, time);
  };
  const auto at_motion = [&](const char* name, Law law, const char* doc) {
    bound.def(
        name,
        ", *, position: numpy.typing.ArrayLike = 0.0, velocity: numpy.typing.ArrayLike = 0.0, "
        "time: numpy.typing.ArrayLike = 0.0) -> object",
        doc,
        [along, law](const Self& self, const Values& position, const Values& velocity, const Values& time) {
          return along(self, law, position, velocity, time);
        },
        py::kw_only(), py::arg("position") = 0.0, py::arg("velocity") = 0.0, py::arg("time") = 0.0);
  };
  const auto at_one = [&](const char* name, Law law, const std::string& argument, const char* doc) {
    bound.def(
        name, ", " + argument + ": numpy.typing.ArrayLike) -> object", doc,
        [along, law](const Self& self, const Values& values) {
          return along(self, law, values, Values(py::float_(0.0)), Values(py::float_(0.0)));
        },
        py::arg(argument.c_str()));
  };
  for (const auto& [hook, law] : effect.hooks) {
    if (hook == "force") at_motion("force_at", law, "Force (V) at positions (m), velocities (m/s) and times (s).");
    if (hook == "friction_level")
      at_motion("friction_level_at", law,
                "Level (V) that it adds to Fc at positions (m), velocities (m/s) and times (s).");
    if (hook == "command_gain")
      bound.def(
          "gain_at", ", *, position: numpy.typing.ArrayLike = 0.0, time: numpy.typing.ArrayLike = 0.0) -> object",
          "What it adds to the gain 1 of the command (relative) at positions (m) and times (s).",
          [along, gain = law](const Self& self, const Values& position, const Values& time) {
            return along(self, gain, position, Values(py::float_(0.0)), time);
          },
          py::kw_only(), py::arg("position") = 0.0, py::arg("time") = 0.0);
    if (hook == "shape_command") at_one("shape_at", law, "command", "What the amplifier makes of commands, V.");
    if (hook == "reading")
      at_one("reading_at", law, "position", "What the encoder reads at positions, m, before noise and rounding.");
  }
  bound.def(
      "resolved",
      ", axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> " + bound.name(),
      "A copy whose fields that stand for those of the plant (travel, knots) are filled in.\n\n"
      "Raises:\n    ValueError: the plant lacks what it needs.",
      [bound, resolved](const Self& self, const AxisParameters<>& axis, const std::optional<CoggingModel<>>& cogging) {
        return resolved(bound.data_of(self), context_of(axis, cogging.value_or(CoggingModel<>())));
      },
      py::arg("axis"), py::arg("cogging") = py::none());
}

void bind_listed(py::dict& effects, const py::object& type, const ListedEffect& effect) {
  type.attr("NAME") = effect.name;
  type.attr("LAW") = effect.law;
  py::list hooks;
  for (const auto& [hook, law] : effect.hooks) hooks.append(hook);
  type.attr("HOOKS") = py::tuple(hooks);
  type.attr("ROLES") = roles_of(effect.parameters);
  type.attr("KINDS") = py::tuple(py::cast(effect.kinds));
  bind_laws(type, effect);
  effects[py::str(effect.name)] = type;
}

template <class E>
void bind_effect(py::module_& module, py::dict& effects) {
  if constexpr (!ChoosesHooks<E>) {  // of others each says itself what it is: own_effect.cpp
    const ListedEffect effect = listed_effect<E>();
    const std::string doc = "Effect `" + effect.name + "`: " + effect.law + ".";
    bind_listed(effects, bind_parameters<E>(module, class_name(effect.name), doc, effect.parameters), effect);
  }
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
  Alternatives<Effect<>>::for_each([&]<class E>() { bind_effect<E>(submodule, effects); });
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
