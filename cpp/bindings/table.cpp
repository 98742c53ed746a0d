#include "bindings.hpp"
#include "cogging/table/number_reader.hpp"
#include "cogging/table/number_writer.hpp"
#include "without_gil.hpp"

using namespace cogging;

void bind_table(py::module_& module) {
  py::class_<NumberReader>(module, "NumberReader", R"(Columns of numbers out of separated text, block by block.

separator: one character, " " = any run of blanks; fields: how many each line has; wanted: indexes of those to read,
ascending, with a label each. Rows first_row to end_row (without) are kept; first_line numbers the first line that will
come. Blank lines are skipped, a number may stand in quotes.

Raises:
    ValueError: a line with other than `fields` fields, or a wanted one that is no finite number; names the line.)")
      .def(py::init([](char separator, std::size_t fields, const std::vector<std::size_t>& wanted,
                       const std::vector<std::string>& labels, std::size_t first_row,
                       const std::optional<std::size_t>& end_row, std::size_t first_line, std::size_t expected_rows) {
             return NumberReader({separator, fields, wanted, labels}, first_row,
                                 end_row.value_or(std::numeric_limits<std::size_t>::max()), first_line, expected_rows);
           }),
           py::kw_only(), py::arg("separator"), py::arg("fields"), py::arg("wanted"), py::arg("labels"),
           py::arg("first_row") = 0, py::arg("end_row") = py::none(), py::arg("first_line") = 1,
           py::arg("expected_rows") = 0)
      .def(
          "feed",
          [](NumberReader& reader, const py::bytes& block) {
            const std::string_view view(block);
            without_gil([&](StopRequest* stop) { reader.feed(view, stop); });
          },
          py::arg("block"), "Take the next block of the file, which may end anywhere.")
      .def("finish", &NumberReader::finish, "Take what stands after the last line end.")
      .def_property_readonly("done", &NumberReader::done, "whether the last wanted row has been read")
      .def_property_readonly("rows", &NumberReader::rows, "rows read so far")
      .def(
          "take",
          [](NumberReader& reader) {
            std::vector<py::array_t<double>> arrays;
            for (std::vector<double>& column : reader.take()) arrays.push_back(to_array(std::move(column)));
            return arrays;
          },
          "The columns, (n,) each, in the order of `wanted`; the reader is empty afterwards.");

  module.def(
      "format_rows",
      [](const std::vector<Array>& columns, std::size_t first, std::size_t end) {
        std::vector<std::span<const double>> views;
        for (const Array& column : columns) {
          require(first <= end && end <= static_cast<std::size_t>(column.size()), "end",
                  "must be from first to the length of every column", static_cast<double>(end));
          views.emplace_back(column.data(), static_cast<std::size_t>(column.size()));
        }
        return py::bytes(without_gil([&](StopRequest* stop) { return format_rows(views, first, end, stop); }));
      },
      py::arg("columns"), py::arg("first"), py::arg("end"),
      "Rows first to end (without) of columns (n,) as comma-separated lines, every number to its last bit.");
}
