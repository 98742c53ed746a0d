#include "bound_class.hpp"
#include "cogging/control/compiled.hpp"
#include "cogging/control/desired_compensation_condition.hpp"
#include "cogging/control/list.hpp"
#include "controller_state.hpp"
#include "instantiated.hpp"
#include "real_number.hpp"

using namespace cogging;

namespace {

constexpr const char* refusal = R"(

A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
`command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
of the next reading are taken over all samples that have passed.)";

std::string controller_example(const std::string& name) {
  return "\n\nExample:\n    >>> controller = cogging." + name + "(cogging." + name +
         ".PARAMETERS(sample_rate=2000.0))\n    >>> controller.sample_rate\n    2000.0";
}

using RealPoint = std::array<Real, 3>;

ReferencePoint point(const RealPoint& of) {
  return {of[0].value, of[1].value, of[2].value};
}

// A controller of the list, whatever its type.
struct ListedController {
  void* (*make)(const py::handle& parameters);
  void* (*restored)(const py::handle& parameters, const std::vector<double>& numbers);  // with the numbers of its state
  std::vector<double> (*numbers)(const void* controller);
  py::object (*parameters)(const void* controller);
  py::object (*copy)(const void* controller);
  py::object (*sample_rate)(const void* controller);
  py::object (*samples_refused)(const void* controller);
  py::object (*estimates)(const void* controller);
  double (*command)(void* controller, const ReferencePoint& reference, const ReferencePoint& ahead, double reading);
  void (*update)(void* controller, double applied);
  py::object (*preview)(const void* controller) = nullptr;  // of one that looks ahead
};

template <class C>
ListedController listed_controller() {
  using Parameters = typename C::Parameters;
  ListedController listed{
      [](const py::handle& parameters) -> void* { return new C(parameters.cast<const Parameters&>()); },
      [](const py::handle& parameters, const std::vector<double>& numbers) -> void* {
        auto controller = std::make_unique<C>(parameters.cast<const Parameters&>());
        set_numbers(*controller, numbers);
        return controller.release();
      },
      [](const void* controller) { return numbers_of(object_at<C>(controller)); },
      [](const void* controller) { return py::cast(object_at<C>(controller).parameters()); },
      // Of a copy: a cast of what an object holds gives that object.
      [](const void* controller) { return py::cast(C(object_at<C>(controller))); },
      [](const void* controller) -> py::object { return py::float_(object_at<C>(controller).sample_rate()); },
      [](const void* controller) -> py::object {
        return py::int_(whole_part<std::uint64_t>(object_at<C>(controller).samples_refused()));
      },
      [](const void* controller) -> py::object {
        const auto estimates = object_at<C>(controller).estimates();
        return to_array({estimates.begin(), estimates.end()});
      },
      [](void* controller, const ReferencePoint& reference, [[maybe_unused]] const ReferencePoint& ahead,
         double reading) {
        if constexpr (LooksAhead<C>)
          return static_cast<C*>(controller)->command(reference, ahead, reading);
        else
          return static_cast<C*>(controller)->command(reference, reading);
      },
      [](void* controller, double applied) { static_cast<C*>(controller)->update(applied); }};
  if constexpr (LooksAhead<C>)
    listed.preview = [](const void* controller) -> py::object {
      return py::float_(object_at<C>(controller).preview());
    };
  return listed;
}

#define COGGING_POINT "typing.Annotated[collections.abc.Sequence[float], \"FixedSize(3)\"]"

void bind_command(const BoundClass& bound, const ListedController& listed) {
  const auto command = listed.command;
  if (listed.preview != nullptr) {
    bound.def_property("preview", "float", "how far ahead the second reference is, s", listed.preview);
    bound.def(
        "command", ", *, reference: " COGGING_POINT ", ahead: " COGGING_POINT ", reading: float) -> float",
        "The command (V) of this sample from the reference now and `preview` s ahead (each m, m/s, m/s^2) and encoder "
        "reading (m).",
        [bound, command](const Self& self, const RealPoint& reference, const RealPoint& ahead, Real reading) {
          return command(bound.data_of(self), point(reference), point(ahead), reading.value);
        },
        py::kw_only(), py::arg("reference"), py::arg("ahead"), py::arg("reading"));
    return;
  }
  const std::string doc =
      ", reading: float) -> float\n\n"
      "The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).\n";
  bound.def_documented(
      "command",
      "command(*args, **kwargs)\nOverloaded function.\n\n1. command(self: " + bound.name() +
          ", *, reference: float, reference_velocity: float = 0.0, reference_acceleration: float = 0.0" + doc,
      [bound, command](const Self& self, Real position, Real velocity, Real acceleration, Real reading) {
        return command(bound.data_of(self), point({position, velocity, acceleration}), {}, reading.value);
      },
      py::kw_only(), py::arg("reference"), py::arg("reference_velocity") = 0.0, py::arg("reference_acceleration") = 0.0,
      py::arg("reading"));
  bound.def_documented(
      "command", "2. command(self: " + bound.name() + ", reference: " COGGING_POINT + doc,
      [bound, command](const Self& self, const RealPoint& reference, Real reading) {
        return command(bound.data_of(self), point(reference), {}, reading.value);
      },
      py::arg("reference"), py::arg("reading"));
}

void bind_listed(const py::object& type, const std::string& parameters, const ListedController& listed) {
  const BoundClass bound(type);
  bound.def(
      "__init__", ", parameters: " + parameters + ") -> None", "",
      [make = listed.make](py::detail::value_and_holder& self, const py::object& given) {
        try {
          self.value_ptr() = make(given);
        } catch (const py::cast_error&) {  // ends as any call that no signature takes (module.cpp)
          throw py::type_error("__init__(): incompatible constructor arguments: parameters");
        }
      },
      py::detail::is_new_style_constructor(), py::arg("parameters"));
  bound.def_property("parameters", parameters, "", listed.parameters);
  bound.def_property("sample_rate", "float", "Hz", listed.sample_rate);
  bound.def_property("estimates", "numpy.typing.NDArray[numpy.float64]",
                     "What it believes now, (p,): a copy; empty for a controller that does not adapt.",
                     listed.estimates);
  bound.def_property("samples_refused", "int",
                     "How many samples were refused so far, for a reading or a reference that is not finite.",
                     listed.samples_refused);
  bound.def(
      "update", ", applied: float) -> None",
      "Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, "
      "cut at the limit.",
      [bound, update = listed.update](const Self& self, Real applied) { update(bound.data_of(self), applied.value); },
      py::arg("applied"));
  const auto copy = [bound, copy = listed.copy](const Self& self) { return copy(bound.data_of(self)); };
  bound.def("copy", ") -> " + bound.name(), "A controller in the same state.", copy);
  bound.def("__copy__", ") -> " + bound.name(), "", copy);
  bound.def(
      "__deepcopy__", ", memo: dict) -> " + bound.name(), "",
      [copy](const Self& self, const py::dict&) { return copy(self); }, py::arg("memo"));
  bound.def("__getstate__", ", /) -> tuple[" + parameters + ", list[float]]", "", [bound, listed](const Self& self) {
    const void* controller = bound.data_of(self);
    return py::make_tuple(listed.parameters(controller), listed.numbers(controller));
  });
  bound.def(
      "__setstate__", ", arg0: tuple) -> None", "",
      [restored = listed.restored](py::detail::value_and_holder& self, const py::tuple& kept) {
        self.value_ptr() = restored(kept[0], kept[1].cast<std::vector<double>>());
      },
      py::detail::is_new_style_constructor());
  bind_command(bound, listed);
}

void bind_output_feedback(py::class_<OutputFeedbackArc<>>& bound) {
  using Ofarc = OutputFeedbackArc<>;
  bound.def_property_readonly("z_1", &Ofarc::z_1, "y - q_d of the last sample, m")
      .def_property_readonly("z_2", &Ofarc::z_2, "lambda_2 - alpha_1 of the last sample")
      .def_property_readonly("filters", &Ofarc::filters, "eta, lambda, psi: array of six")
      .def("velocity_state", &Ofarc::velocity_state, py::arg("theta"),
           "x_2 hat of eq. 13 for a theta: exact for the true one without disturbance.")
      .def(
          "virtual_control",
          [](const Ofarc& c, double position, double eta_1, double eta_2, double psi_2, double reference,
             double reference_velocity, const std::array<double, 3>& theta) {
            const auto a = c.virtual_control({position, eta_1, eta_2, psi_2, reference, reference_velocity, theta});
            return std::map<std::string, double>{{"value", a.value},
                                                 {"position", a.position},
                                                 {"eta_1", a.eta_1},
                                                 {"eta_2", a.eta_2},
                                                 {"psi_2", a.psi_2},
                                                 {"reference", a.reference},
                                                 {"reference_velocity", a.reference_velocity},
                                                 {"theta_1", a.theta[0]},
                                                 {"theta_2", a.theta[1]},
                                                 {"theta_3", a.theta[2]}};
          },
          py::kw_only(), py::arg("position"), py::arg("eta_1"), py::arg("eta_2"), py::arg("psi_2"),
          py::arg("reference"), py::arg("reference_velocity"), py::arg("theta"),
          "alpha_1 (eq. 25, 27) as `value`, and its partial derivatives by the name of the argument.");
}

template <class C>
void bind_controller(py::module_& module, py::dict& controllers) {
  const std::string name = class_name(C::name);
  const py::object parameters = bind_parameters_of<C>(module);
  py::class_<C> bound(module, name.c_str(), (std::string(C::description) + refusal + controller_example(name)).c_str());
  bind_listed(bound, BoundClass(parameters).name(), listed_controller<C>());
  if constexpr (std::is_same_v<C, OutputFeedbackArc<>>) bind_output_feedback(bound);
  enlist(module, "controllers", controllers, C::name, bound, parameters);
}

}  // namespace

void bind_control(py::module_& module) {
  py::module_ names =
      module.def_submodule("controllers", "Every controller that a model file may name, with its parameters.");
  names.attr("__all__") = py::list();
  py::dict controllers;
  Alternatives<AnyController<>>::for_each([&]<class C>() { bind_controller<C>(module, controllers); });
  module.attr("CONTROLLERS") = controllers;

  module.def(
      "desired_compensation_matrix",
      [](double feedback_gain, double error_gain, double mass, double viscous, double coulomb, double friction_slope,
         double cogging_slope) {
        const QuadraticForm form = desired_compensation_matrix(feedback_gain, error_gain, mass, viscous, coulomb,
                                                               friction_slope, cogging_slope);
        return to_array({form.pp, form.pe, form.pe, form.ee}, {2, 2});
      },
      py::kw_only(), py::arg("feedback_gain"), py::arg("error_gain"), py::arg("mass"), py::arg("viscous"),
      py::arg("coulomb"), py::arg("friction_slope"), py::arg("cogging_slope"),
      R"(The matrix of Lu et al. 2008, eq. 29, at one point: array (2, 2).

Args:
    feedback_gain: k_s1, V/(m/s).
    error_gain: k_1, 1/s.
    mass, viscous, coulomb: theta_1 to theta_3, V/(m/s^2), V/(m/s), V.
    friction_slope: g_f of eq. 24, 1/(m/s).
    cogging_slope: theta_4b^T g_r of eq. 25, V/m.

Returns:
    The matrix.

Example:
    >>> axis = {"mass": 0.12, "viscous": 0.2, "coulomb": 0.0, "friction_slope": 0.0, "cogging_slope": 10.0}
    >>> matrix = cogging.desired_compensation_matrix(feedback_gain=48.0, error_gain=200.0, **axis)
    >>> bool(np.linalg.eigvalsh(matrix)[0] > 0.0)
    True)");
  module.def(
      "desired_compensation_condition",
      [](const AdaptiveRobustParameters<>& parameters, double friction_slope, double cogging_slope) {
        const auto condition = desired_compensation_condition(parameters, friction_slope, cogging_slope);
        return py::make_tuple(condition.smallest_eigenvalue, condition.decay_rate);
      },
      py::arg("parameters"), py::kw_only(), py::arg("friction_slope"), py::arg("cogging_slope"),
      R"(Smallest eigenvalue of the matrix (29) over the bounds and slopes, and the decay rate (1/s) it gives.

Over mass, viscous and Coulomb bounds, 0 <= g_f <= friction_slope (1/(m/s)), |theta_4b^T g_r| <= cogging_slope (V/m).
Above zero, V = M p^2 / 2 + M k_1^2 e^2 / 2 obeys V' <= -rate V + epsilon. At or below zero k_s1 is too small.

Args:
    parameters: gains and bounds of Arc or Dcarc.
    friction_slope: the largest, 1/(m/s).
    cogging_slope: the largest, V/m.

Returns:
    The eigenvalue and the rate.

Example:
    >>> gains = cogging.AdaptiveRobustParameters(feedback_gain=48.0, error_gain=200.0, mass_bounds=[0.1, 0.14])
    >>> eigenvalue, rate = cogging.desired_compensation_condition(gains, friction_slope=0.0, cogging_slope=10.0)
    >>> print(f"{eigenvalue:.1f}, {rate:.0f} 1/s")
    20.0, 286 1/s)");
  module.def("friction_slope_max", &friction_slope_max, py::arg("coulomb_width"),
             R"(Steepest slope of S(v) = (2/pi) atan(v / coulomb_width): 2 / (pi coulomb_width), 1/(m/s).

Args:
    coulomb_width: m/s.

Returns:
    The slope.

Example:
    >>> print(f"{cogging.friction_slope_max(1.11e-3):.1f}")
    573.5)");
  module.def("cogging_slope_max", &cogging_slope_max, py::arg("basis"), py::arg("amplitude"),
             R"(Bound on |d/dx A_r^T S_r(x)| (V/m) when every coefficient lies in [-amplitude, amplitude] (V).

Args:
    basis: a SplineHarmonics.
    amplitude: V.

Returns:
    The bound.

Example:
    >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
    >>> print(f"{cogging.cogging_slope_max(basis, 0.1):.1f}")
    53.3)");
  module.def("project", &project<double>, py::arg("rate"), py::arg("estimate"), py::arg("minimum"), py::arg("maximum"),
             R"(The adaptation rate, 0 where it would leave the bound (Lu et al. 2008, eq. 14).

Args:
    rate: of the estimate, a second.
    estimate: as it is.
    minimum, maximum: of the estimate.

Returns:
    The rate that is left.

Example:
    >>> cogging.project(2.0, 1.0, 0.0, 1.0), cogging.project(-2.0, 1.0, 0.0, 1.0)
    (0.0, -2.0))");
}
