#include "bindings.hpp"
#include "cogging/estimation/whitening.hpp"
#include "cogging/simulation/batch.hpp"
#include "without_gil.hpp"

using namespace cogging;

void bind_estimation(py::module_& module) {
  module.def(
      "autoregression",
      [](const Array& residual, const Array& counts, int order) {
        require(counts.size() == residual.size(), "counts", "must be as long as residual", double(counts.size()));
        return without_gil([&](StopRequest* stop) {
          return autoregression({residual.data(), std::size_t(residual.size())},
                                {counts.data(), std::size_t(counts.size())}, order, stop);
        });
      },
      py::arg("residual"), py::arg("counts"), py::kw_only(), py::arg("order"),
      R"(Coefficients a (order,) of e_k = r_k - sum_i a_i r_(k-i) with the least rms of e.

Yule and Walker's equations; rows with counts = 0 and pairs with one of them are left out.

Raises:
    ValueError: lengths differ, order above a quarter of the rows, nothing that counts.)");
  module.def(
      "whiten",
      [](const Array& rows, const std::vector<double>& coefficients, unsigned threads) {
        require(rows.ndim() == 2, "rows", "must be (p, n)", double(rows.ndim()));
        const std::size_t count = std::size_t(rows.shape(0)), length = std::size_t(rows.shape(1));
        std::vector<double> values(count * length);
        without_gil([&](StopRequest* stop) {
          run_batch(count, threads, stop, [&](std::size_t i) {
            const std::vector<double> white = whiten({rows.data() + i * length, length}, coefficients, stop);
            std::copy(white.begin(), white.end(), values.begin() + static_cast<std::ptrdiff_t>(i * length));
          });
        });
        return to_array(std::move(values), {rows.shape(0), rows.shape(1)});
      },
      py::arg("rows"), py::arg("coefficients"), py::kw_only(), py::arg("threads") = 0,
      "e_k = r_k - sum_i a_i r_(k-i) of every row of (p, n); r is 0 before the first column.");
}
