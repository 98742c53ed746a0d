
#include "bindings.hpp"
#include "cogging/table/number_reader.hpp"
#include "cogging/table/number_writer.hpp"
#include "gil.hpp"

using namespace cogging;

namespace {

// A reader for Python, whose threads may meet in it: blocks that overtake each other make no table.
class OneThreadReader {
 public:
  explicit OneThreadReader(NumberReader reader) : reader_(std::move(reader)) {}

  /// Calls call(reader), or refuses where another thread is within a call.
  template <class Call>
  auto use(const Call& call) {
    if (busy_.test_and_set(std::memory_order_acquire))
      refuse("NumberReader", "must be used by one thread at a time", "a call within another");
    const struct Release {
      std::atomic_flag& flag;
      ~Release() { flag.clear(std::memory_order_release); }
    } release{busy_};
    return call(reader_);
  }

 private:
  NumberReader reader_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

// Counts come signed, so that a negative one is told as such.
std::string rows_as_text(const std::vector<Array>& columns, py::ssize_t first, py::ssize_t end) {
  require(!columns.empty(), "columns", "must be at least one", 0.0);
  require(first >= 0, "first", "must be at least 0", first);
  std::vector<std::span<const double>> views;
  for (const Array& column : columns) {
    require(first <= end && end <= column.size(), "end", "must be from first to the length of every column", end);
    views.emplace_back(column.data(), static_cast<std::size_t>(column.size()));
  }
  return without_gil([&](StopRequest* stop) {
    return format_rows(views, static_cast<std::size_t>(first), static_cast<std::size_t>(end), stop);
  });
}

}  // namespace

void bind_table(py::module_& module) {
  py::class_<OneThreadReader>(module, "NumberReader", R"(Columns of numbers out of separated text, block by block.

separator: one character, " " = any run of blanks; fields: how many each line has; wanted: indexes of those to read,
ascending, with a label each. Rows first_row to end_row (without) are kept; first_line numbers the first that comes.)")
      .def(py::init([](char separator, std::size_t fields, const std::vector<std::size_t>& wanted,
                       const std::vector<std::string>& labels, std::size_t first_row,
                       const std::optional<std::size_t>& end_row, std::size_t first_line, std::size_t expected_rows,
                       char decimal) {
             return std::make_unique<OneThreadReader>(
                 NumberReader({separator, fields, wanted, labels, decimal}, first_row,
                              end_row.value_or(std::numeric_limits<std::size_t>::max()), first_line, expected_rows));
           }),
           py::kw_only(), py::arg("separator"), py::arg("fields"), py::arg("wanted"), py::arg("labels"),
           py::arg("first_row") = 0, py::arg("end_row") = py::none(), py::arg("first_line") = 1,
           py::arg("expected_rows") = 0, py::arg("decimal") = '.')
      .def(
          "feed",
          [](OneThreadReader& reader, const py::bytes& block) {
            const std::string_view view(block);
            without_gil([&](StopRequest* stop) { reader.use([&](NumberReader& one) { one.feed(view, stop); }); });
          },
          py::arg("block"), "Take the next block of the file, which may end anywhere.")
      .def(
          "finish", [](OneThreadReader& reader) { reader.use([](NumberReader& one) { one.finish(); }); },
          "Take what stands after the last line end.")
      .def_property_readonly(
          "done", [](OneThreadReader& reader) { return reader.use([](NumberReader& one) { return one.done(); }); },
          "whether the last wanted row has been read")
      .def_property_readonly(
          "rows", [](OneThreadReader& reader) { return reader.use([](NumberReader& one) { return one.rows(); }); },
          "rows read since the start or the last `take`")
      .def(
          "take",
          [](OneThreadReader& reader) {
            std::vector<py::array_t<double>> arrays;
            auto columns = reader.use([](NumberReader& one) { return one.take(); });
            for (std::vector<double>& column : columns) arrays.push_back(to_array(std::move(column)));
            return arrays;
          },
          "The columns, (n,) each, in the order of `wanted`; the reader is empty afterwards and may read on.");

  module.def(
      "format_rows",
      [](const std::vector<Array>& columns, py::ssize_t first, py::ssize_t end) {
        return py::bytes(rows_as_text(columns, first, end));
      },
      py::arg("columns"), py::arg("first"), py::arg("end"),
      "Rows first to end (without) of columns (n,) as comma-separated lines, every number to its last bit.");
}
