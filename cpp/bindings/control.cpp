#include "bindings.hpp"
#include "cogging/control/adaptive_robust.hpp"
#include "cogging/control/cascade.hpp"
#include "cogging/control/desired_compensation_condition.hpp"
#include "cogging/control/observer_based.hpp"
#include "cogging/control/output_feedback_adaptive_robust.hpp"
#include "cogging/control/pid.hpp"
#include "cogging/control/speed.hpp"
#include "controller_state.hpp"

using namespace cogging;

namespace {

constexpr const char* refusal = R"(

A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
`command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
of the next reading are taken over all samples that have passed.)";

template <class C>
py::class_<C> bind_controller(py::module_& module, const char* name, const std::string& doc) {
  static_assert(Controller<C, double>);
  py::class_<C> bound(module, name, (doc + refusal).c_str());
  bound.def(py::init<const typename C::Parameters&>(), py::arg("parameters"))
      .def_property_readonly("parameters", &C::parameters, py::return_value_policy::copy)
      .def_property_readonly("sample_rate", &C::sample_rate, "Hz")
      .def_property_readonly(
          "estimates",
          [](const C& c) { return to_array(std::vector<double>(c.estimates().begin(), c.estimates().end())); },
          "What it believes now, (p,): a copy; empty for a controller that does not adapt.")
      .def_property_readonly(
          "samples_refused", [](const C& c) { return static_cast<std::uint64_t>(c.samples_refused()); },
          "How many samples were refused so far, for a reading or a reference that is not finite.")
      .def("update", &C::update, py::arg("applied"),
           "Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its "
           "own, cut at the limit.")
      .def("copy", [](const C& c) { return c; }, "A controller in the same state.");
  bind_state(bound);
  constexpr const char* command_doc =
      "The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).";
  if constexpr (LooksAhead<C>)
    bound.def(
        "command",
        [](C& c, const std::array<double, 3>& reference, const std::array<double, 3>& ahead, double reading) {
          return c.command({reference[0], reference[1], reference[2]}, {ahead[0], ahead[1], ahead[2]}, reading);
        },
        py::kw_only(), py::arg("reference"), py::arg("ahead"), py::arg("reading"),
        "The command (V) of this sample from the reference now and `preview` s ahead (each m, m/s, m/s^2) and encoder "
        "reading (m).");
  else
    bound.def(
        "command",
        [](C& c, double position, double velocity, double acceleration, double reading) {
          return c.command(ReferencePoint{position, velocity, acceleration}, reading);
        },
        py::kw_only(), py::arg("reference"), py::arg("reference_velocity") = 0.0,
        py::arg("reference_acceleration") = 0.0, py::arg("reading"), command_doc);
  return bound;
}

}  // namespace

void bind_control(py::module_& module) {
  bind_parameters<PidParameters<>>(module, "PidParameters", "Gains and feedforward of a Pid.");
  bind_controller<Pid<>>(module, "Pid", R"(PID with feedforward, from positions only.

u = mass a_r + viscous v + coulomb S(v) - kp e - ki sum(e Ts) - kd (e - e_prev) / Ts, e = reading - reference. The sum
includes the current sample and starts at zero; e_prev = e in the first sample. With a command limit the sum does not
take up an error that pushes further into it.)");

  bind_parameters<CascadeParameters<>>(module, "CascadeParameters", "Gains and feedforward of a Cascade.");
  bind_controller<Cascade<>>(
      module, "Cascade",
      "u = kv (kp (reference - reading) - v) + feedforward, v the backward difference of the reading.");

  bind_parameters<SpeedParameters<>>(module, "SpeedParameters", "Gain, delay and feedforward of a Speed.");
  bind_controller<Speed<>>(module, "Speed", R"(A velocity loop, from positions only.

w = kp (v_r - v) + feedforward, put out `delay` later; v is the backward difference of the reading, 0 in the first
sample. With delay = (n + f) / sample_rate, 0 <= f < 1, the command of sample k is (1 - f) w[k-n] + f w[k-n-1], w = 0
before the first sample: the mean over the sample of the held w after the exact delay. What is held in a sample that is
refused is w, which goes through the delay as ever.)");

  bind_parameters<AdaptiveRobustParameters<>>(
      module, "AdaptiveRobustParameters",
      "Gains, bounds and initial estimates of Arc and Dcarc (Lu et al. 2008, eq. 11 to 30).");
  bind_controller<Arc<>>(module, "Arc", R"(Adaptive robust control (Lu et al. 2008, eq. 15 to 23).

u = -phi^T theta_hat - k_s1 p + u_s2 with p = e' + k_1 e, the regressor phi at the measured state;
theta_hat' = Proj(Gamma phi p), one Euler step a sample. Estimates: mass, viscous, coulomb, d_n, then A_r.)");
  bind_controller<Dcarc<>>(module, "Dcarc",
                           R"(Desired compensation adaptive robust control (Lu et al. 2008, eq. 24 to 30).

As Arc, with the regressor on the reference in place of the measured state. Estimates: mass, viscous, coulomb, d_n,
then A_r.)");

  bind_parameters<OutputFeedbackArcParameters<>>(
      module, "OutputFeedbackArcParameters",
      "Observer, gains, bounds and robust terms of an OutputFeedbackArc (Xu and Yao 2001, eq. 8 to 50).");
  using Ofarc = OutputFeedbackArc<>;
  bind_controller<Ofarc>(module, "OutputFeedbackArc", R"(Output-feedback adaptive robust control (Xu and Yao 2001).

u = u* + coulomb S(reference velocity): filters (18), state estimate (13), two backstepping steps (25) to (47),
adaptation (50) with projection. theta = [1/M, B/M, d_n/M]. Positions count from the first reading. The
filters of the applied command go on through samples that are refused; that of the readings makes up for them behind.)")
      .def_property_readonly("z_1", &Ofarc::z_1, "y - q_d of the last sample, m")
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

  bind_parameters<ObserverBasedParameters<>>(
      module, "ObserverBasedParameters",
      "Periods and gains of an ObserverBased (Malaize and Levine 2009, eq. 2, 6, 8).");
  bind_controller<ObserverBased<>>(module, "ObserverBased", R"(Observer-based cancellation (Malaize and Levine 2009).

Extended observer (6) of position, velocity, lambda_0 and each spatial period, and law (8); K from gains.design_observer.
Positions only. Estimates: x_hat, nu_hat, lambda_0, then sine and cosine of each period. Behind more than 16 samples that
were refused x_hat and nu_hat start anew from the readings at both ends.)")
      .def_property_readonly("preview", &ObserverBased<>::preview, "how far ahead the second reference is, s");

  module.def(
      "desired_compensation_matrix",
      [](double feedback_gain, double error_gain, double mass, double viscous, double coulomb, double friction_slope,
         double cogging_slope) {
        const QuadraticForm form = desired_compensation_matrix(feedback_gain, error_gain, mass, viscous, coulomb,
                                                               friction_slope, cogging_slope);
        return Eigen::Matrix2d{{form.pp, form.pe}, {form.pe, form.ee}};
      },
      py::kw_only(), py::arg("feedback_gain"), py::arg("error_gain"), py::arg("mass"), py::arg("viscous"),
      py::arg("coulomb"), py::arg("friction_slope"), py::arg("cogging_slope"),
      R"(The matrix of Lu et al. 2008, eq. 29, at one point: array (2, 2).

friction_slope is g_f of eq. 24, 1/(m/s); cogging_slope is theta_4b^T g_r of eq. 25, V/m.)");
  module.def(
      "desired_compensation_condition",
      [](const AdaptiveRobustParameters<>& parameters, double friction_slope, double cogging_slope) {
        const auto condition = desired_compensation_condition(parameters, friction_slope, cogging_slope);
        return py::make_tuple(condition.smallest_eigenvalue, condition.decay_rate);
      },
      py::arg("parameters"), py::kw_only(), py::arg("friction_slope"), py::arg("cogging_slope"),
      R"(Smallest eigenvalue of the matrix (29) over the bounds and slopes, and the decay rate (1/s) it gives.

Over mass, viscous and Coulomb bounds, 0 <= g_f <= friction_slope (1/(m/s)), |theta_4b^T g_r| <= cogging_slope (V/m).
Above zero, V = M p^2 / 2 + M k_1^2 e^2 / 2 obeys V' <= -rate V + epsilon. At or below zero k_s1 is too small.)");
  module.def("friction_slope_max", &friction_slope_max, py::arg("coulomb_width"),
             "Steepest slope of S(v) = (2/pi) atan(v / coulomb_width): 2 / (pi coulomb_width), 1/(m/s).");
  module.def("cogging_slope_max", &cogging_slope_max, py::arg("basis"), py::arg("amplitude"),
             "Bound on |d/dx A_r^T S_r(x)| (V/m) when every coefficient lies in [-amplitude, amplitude] (V).");
  module.def("project", &project<double>, py::arg("rate"), py::arg("estimate"), py::arg("minimum"), py::arg("maximum"),
             "The adaptation rate, 0 where it would leave the bound (Lu et al. 2008, eq. 14).");
}
