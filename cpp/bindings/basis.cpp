#include "bindings.hpp"
#include "cogging/basis/regressor.hpp"
#include "cogging/basis/spline_harmonics.hpp"

using namespace cogging;

namespace {

// A table (positions, columns), written by write(positions, table).
template <class Write>
py::array_t<double> table(const Array& positions, int columns, const Write& write) {
  require(positions.ndim() == 1, "positions", "must be (n,), dimensions", positions.ndim());
  std::vector<double> values(std::size_t(positions.size()) * std::size_t(columns));
  write(view(positions), std::span(values));
  return to_array(std::move(values), {positions.size(), columns});
}

py::array_t<double> design_matrix(const BSpline& spline, const Array& positions) {
  return table(positions, spline.control_points(),
               [&](auto at, auto values) { write_design_matrix(spline, at, values); });
}

py::array_t<double> regressor(const SplineHarmonics& basis, const Array& positions) {
  return table(positions, basis.coefficients(), [&](auto at, auto values) { write_regressor(basis, at, values); });
}

BSpline make_spline(std::int64_t order, double origin, double pitch, std::int64_t control_points) {
  return BSpline(counted("order", order), origin, pitch, counted("control_points", control_points));
}

SplineHarmonics make_basis(std::optional<double> pitch, std::optional<std::vector<std::int64_t>> harmonics,
                           std::optional<std::vector<double>> periods, std::int64_t order, double origin,
                           std::int64_t control_points) {
  if (harmonics.has_value() == periods.has_value())
    refuse("harmonics, periods", "exactly one of them must be given", harmonics ? "both" : "neither");
  if (!pitch && (harmonics || control_points > 1)) refuse("pitch", "must be given", "nothing");
  const BSpline spline = make_spline(order, origin, pitch.value_or(1.0), control_points);
  if (harmonics)
    return SplineHarmonics::of_harmonics(*pitch, taken<std::vector<int>>("harmonics", std::move(*harmonics)), spline);
  return SplineHarmonics::of_periods(*periods, spline);
}

// Rows of the model file: one a term, one column a control point; a list of numbers has one column.
CoggingModel<> make_model(const SplineHarmonics& basis, const Array& sine, const Array& cosine) {
  const py::ssize_t terms = basis.terms(), points = basis.spline().control_points();
  std::vector<double> coefficients(std::size_t(basis.coefficients()));
  const auto put = [&](const Array& rows, const char* name, py::ssize_t offset) {
    const bool table = rows.ndim() == 1 || rows.ndim() == 2;
    const py::ssize_t height = table ? rows.shape(0) : 0, width = rows.ndim() == 2 ? rows.shape(1) : 1;
    if (height != terms || width != points)
      refuse(name, "must have " + format(terms) + " rows (terms) of " + format(points) + " (control points)",
             format(height) + " rows of " + format(width));
    for (py::ssize_t i = 0; i < terms; ++i)
      for (py::ssize_t c = 0; c < points; ++c) {
        const double value = rows.data()[i * points + c];
        require_finite(name, value);
        coefficients[std::size_t(c * basis.columns() + 2 * i + offset)] = value;
      }
  };
  put(sine, "sine", 0);
  put(cosine, "cosine", 1);
  return {basis, coefficients};
}

py::array_t<double> amplitudes(const CoggingModel<>& model, py::ssize_t offset) {
  const SplineHarmonics& basis = model.basis();
  const py::ssize_t terms = basis.terms(), points = basis.spline().control_points();
  std::vector<double> rows;
  for (py::ssize_t i = 0; i < terms; ++i)
    for (py::ssize_t c = 0; c < points; ++c)
      rows.push_back(model.coefficients()[std::size_t(c * basis.columns() + 2 * i + offset)]);
  return to_array(std::move(rows), {terms, points});
}

}  // namespace

void bind_basis(py::module_& module) {
  py::class_<BSpline>(module, "BSpline", R"(Uniform B-spline basis of order k with m control points.

Lu et al. 2008, eq. 6: control point c (from 0) acts on [origin + (c + 1 - k) pitch, origin + (c + 1) pitch).
Between `origin` and `end` the m - k + 1 spans carry k control points each and the basis sums to one; outside, a
spline keeps its end value. One control point is a constant, whatever the order.

Raises:
    ValueError: order not in 1..16, pitch <= 0, control points above one but below the order.

Example:
    >>> spline = cogging.BSpline(order=2, origin=0.0, pitch=0.1, control_points=3)
    >>> spline.design_matrix([0.05]).round(6).tolist()
    [[0.5, 0.5, 0.0]])")
      .def(py::init(&make_spline), py::kw_only(), py::arg("order"), py::arg("origin"), py::arg("pitch"),
           py::arg("control_points"))
      .def_property_readonly("order", &BSpline::order, "k: 1 piecewise constant, 2 linear, 3 quadratic")
      .def_property_readonly("origin", &BSpline::origin, "first knot of the first full span, m")
      .def_property_readonly("pitch", &BSpline::pitch, "distance of the knots, m")
      .def_property_readonly("control_points", &BSpline::control_points, "m")
      .def_property_readonly("end", &BSpline::end, "last knot of the last full span, m")
      .def("design_matrix", &design_matrix, py::arg("positions"),
           "N_{c,k}(x) for positions (n,), m: array (n, control_points).");

  py::class_<SplineHarmonics>(module, "SplineHarmonics",
                              R"(The regressor S_r(x) of the cogging model (Lu et al. 2008, eq. 3 to 7).

F_r(x) = sum_i (f_Si(x) sin(2 pi h_i x / pitch) + f_Ci(x) cos(2 pi h_i x / pitch)), amplitudes f being B-splines; with
`periods` in place of `harmonics`, sin(2 pi x / period). Coefficients A_r: one control point after the other, in each
sine and cosine of every term.

Raises:
    ValueError: a harmonic below 1, a period <= 0, one given twice, both or neither given, no pitch where it is needed.

Example:
    >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
    >>> basis.regressor([0.0125]).round(6).tolist()
    [[1.0, 0.0, 0.0, -1.0]])")
      .def(py::init(&make_basis), py::kw_only(), py::arg("pitch") = py::none(), py::arg("harmonics") = py::none(),
           py::arg("periods") = py::none(), py::arg("order") = 3, py::arg("origin") = 0.0,
           py::arg("control_points") = 1)
      .def_property_readonly("pitch", &SplineHarmonics::pitch, "m; 0 with periods")
      .def_property_readonly("harmonics", &SplineHarmonics::harmonics)
      .def_property_readonly("periods", &SplineHarmonics::periods, "m")
      .def_property_readonly("wavenumbers", &SplineHarmonics::wavenumbers, "2 pi / period of each term, 1/m")
      .def_property_readonly("terms", &SplineHarmonics::terms, "number of harmonics or periods")
      .def_property_readonly("coefficients", &SplineHarmonics::coefficients, "length of A_r")
      .def_property_readonly("spline", &SplineHarmonics::spline, "the B-spline of the amplitudes")
      .def("regressor", &regressor, py::arg("positions"),
           "S_r(x) for positions (n,), m: array (n, coefficients), zero where a control point does not act.")
      .def("active_regressor", &active_regressor, py::arg("position"),
           "Index of the first active coefficient and the values of the active ones, at one position (m).");

  py::class_<CoggingModel<>>(module, "CoggingModel",
                             R"(A cogging force F_cogging(x) that opposes the command, V.

sine, cosine: V, one row a term, one column a control point (Lu et al. 2008, eq. 3 to 7).

Raises:
    ValueError: wrong shape, or a value that is not finite.

Example:
    >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
    >>> cogging.CoggingModel(basis, sine=[[0.1], [0.0]], cosine=[[0.0], [0.02]]).force(0.0125)
    0.08)")
      .def(py::init(&make_model), py::arg("basis"), py::arg("sine"), py::arg("cosine"))
      .def_property_readonly("basis", &CoggingModel<>::basis, "the SplineHarmonics it stands on")
      .def_property_readonly(
          "sine", [](const CoggingModel<>& m) { return amplitudes(m, 0); }, "V")
      .def_property_readonly(
          "cosine", [](const CoggingModel<>& m) { return amplitudes(m, 1); }, "V")
      .def_property_readonly(
          "coefficients", [](const CoggingModel<>& m) { return to_array(std::vector(m.coefficients())); },
          "A_r of eq. 7, V")
      .def("force", py::vectorize([](const CoggingModel<>* m, double x) { return m->force(x); }), py::arg("position"),
           "F_cogging(x), V, at positions in m.")
      .def("slope", py::vectorize([](const CoggingModel<>* m, double x) { return m->slope(x); }), py::arg("position"),
           "dF_cogging/dx, V/m, at positions in m.");
}
