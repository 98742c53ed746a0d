#pragma once
// Columns of numbers out of separated text, block by block: a file larger than memory can be read for a few columns.

#include <charconv>
#include <cstring>
#include <utility>

#include "cogging/interruption.hpp"
#include "cogging/require.hpp"

namespace cogging {

namespace detail {

struct ParsedNumber {
  double value;
  const char* end = nullptr;  // where the number ends; the start if there is none
};

/// The number at the start of [begin, end), to the last bit, whatever the locale; too large is infinite.
inline ParsedNumber parse_number(const char* begin, const char* end) {
  const char* start = begin != end && *begin == '+' ? begin + 1 : begin;
  if (start != begin && start != end && (*start == '-' || *start == '+')) return {0.0, begin};
  double value = 0.0;
#if defined(__cpp_lib_to_chars)
  const auto [stop, code] = std::from_chars(start, end, value);
  if (code == std::errc{}) return {value, stop};
  if (code == std::errc::invalid_argument) return {0.0, begin};
  value = 0.0;  // out of range: what strtod makes of it, zero or infinite
#else
  const char* stop = start;
  while (stop != end && std::strchr("+-.0123456789eEinfatyINFATY", *stop) != nullptr && *stop != '\0') ++stop;
#endif
  const std::string text(start, stop);
  char* text_end = nullptr;
  value = std::strtod(text.c_str(), &text_end);
  if (text_end == text.c_str()) return {0.0, begin};
  return {value, start + (text_end - text.c_str())};
}

}  // namespace detail

/// How the lines of a table are made.
struct TableLayout {
  char separator = ',';             // ' ' = any run of blanks
  std::size_t fields = 0;           // in every line
  std::vector<std::size_t> wanted;  // fields to read, ascending
  std::vector<std::string> labels;  // of the wanted ones, for what is refused
  char decimal = '.';               // or ',': what a number's fraction stands behind
};

/// Reads lines of separated numbers. Blank lines are skipped; a number may stand in quotes; lines end with LF or CR LF.
/// Refuses a line with fewer or more fields than the header, a quote that is not closed in its line or has text behind
/// it, and a wanted field that is no finite number.
class NumberReader {
 public:
  static constexpr std::size_t line_max = std::size_t{1} << 24;  // bytes; a longer line is no row of a log
  static constexpr double rows_max = 1e12;

  /// Rows `first_row` to `end_row` (without) are kept; `first_line` is the number of the first line that will come.
  NumberReader(TableLayout layout, std::size_t first_row, std::size_t end_row, std::size_t first_line,
               std::size_t expected_rows)
      : layout_(std::move(layout)), first_row_(first_row), end_row_(end_row), line_(first_line) {
    require(layout_.labels.size() == layout_.wanted.size(), "labels", "must be one for each wanted field",
            layout_.labels.size());
    if (layout_.decimal != '.' && layout_.decimal != ',')
      refuse("decimal", "must be a point or a comma", std::string(1, layout_.decimal));
    for (std::size_t i = 0; i < layout_.wanted.size(); ++i)
      require(layout_.wanted[i] < layout_.fields && (i == 0 || layout_.wanted[i] > layout_.wanted[i - 1]), "wanted",
              "must be ascending and below fields", layout_.wanted[i]);
    require(expected_rows <= rows_max, "expected_rows", "must be at most " + format(rows_max), expected_rows);
    columns_.resize(layout_.wanted.size());
    for (std::vector<double>& column : columns_) column.reserve(expected_rows);  // pages unused cost nothing
  }

  /// Takes the next block of the file, which may end anywhere. A call that was interrupted, or refused a line, has
  /// taken a part of the block that nobody knows: a reader that is fed on refuses.
  void feed(std::string_view block, StopRequest* request = nullptr) {
    begin_call();
    StopCheck stop(request);
    feed(block, stop);
    whole_ = true;
  }

  /// Takes what stands after the last line end.
  void finish() {
    begin_call();
    if (!carry_.empty() && !done()) read_line(carry_.data(), carry_.data() + carry_.size());
    carry_.clear();
    whole_ = true;
  }

  /// Whether the last wanted row has been read.
  bool done() const { return row_ >= end_row_; }
  /// Rows read since the start or the last `take`.
  std::size_t rows() const { return columns_.empty() ? 0 : columns_.back().size(); }

  /// The columns, all of one length: a line that was refused leaves no part of itself. Reading may go on behind them.
  std::vector<std::vector<double>> take() {
    const std::size_t whole = rows();
    for (std::vector<double>& column : columns_) column.resize(whole);
    return std::exchange(columns_, std::vector<std::vector<double>>(layout_.wanted.size()));
  }

 private:
  void feed(std::string_view block, StopCheck& stop) {
    const char* p = block.data();
    const char* const end = p + block.size();
    if (!carry_.empty()) {
      const char* line_end = find(p, end, '\n');
      carry_.append(p, line_end);
      require_line_length(carry_.size());
      if (line_end == end) return;
      read_line(carry_.data(), carry_.data() + carry_.size());
      carry_.clear();
      p = line_end + 1;
    }
    while (p != end && !done()) {
      stop.row();
      const char* line_end = find(p, end, '\n');
      if (line_end == end) break;
      read_line(p, line_end);
      p = line_end + 1;
    }
    if (!done()) carry_.assign(p, end);
    require_line_length(carry_.size());
  }

  static const char* find(const char* begin, const char* end, char what) {
    const void* found = begin == end ? nullptr : std::memchr(begin, what, static_cast<std::size_t>(end - begin));
    return found ? static_cast<const char*>(found) : end;
  }

  bool is_blank(char c) const { return c == ' ' || (c == '\t' && layout_.separator != '\t'); }
  const char* skip_blanks(const char* p, const char* end) const {
    while (p != end && is_blank(*p)) ++p;
    return p;
  }

  // Where the field at p ends: at a separator outside quotes, or the line's end. Two quotes in quotes are one.
  const char* field_end(const char* p, const char* end) const {
    if (p == end || *p != '"') return bare_end(p, end);
    const char* quote = find(p + 1, end, '"');
    while (quote != end && quote + 1 != end && quote[1] == '"') quote = find(quote + 2, end, '"');
    if (quote == end) refuse(place(), "must close its quotes", shown(p, end));
    const char* stop = layout_.separator == ' ' ? quote + 1 : skip_blanks(quote + 1, end);
    const bool at_end = stop == end || (layout_.separator == ' ' ? is_blank(*stop) : *stop == layout_.separator);
    if (!at_end) refuse(place(), "must have a separator behind closed quotes", shown(p, end));
    return stop;
  }

  const char* bare_end(const char* p, const char* end) const {
    if (layout_.separator != ' ') return find(p, end, layout_.separator);
    while (p != end && !is_blank(*p)) ++p;
    return p;
  }

  static std::string shown(const char* begin, const char* end) {
    constexpr std::ptrdiff_t most = 40;
    const bool cut = end - begin > most;
    return "'" + std::string(begin, cut ? begin + most : end) + (cut ? "...'" : "'");
  }

  void read_line(const char* p, const char* end) {
    ++line_;
    if (p != end && end[-1] == '\r') --end;
    p = skip_blanks(p, end);
    if (p == end) return;
    if (row_ < first_row_) {
      ++row_;
      return;
    }
    std::size_t field = 0, next = 0;
    while (true) {
      const bool wanted = next < layout_.wanted.size() && layout_.wanted[next] == field;
      const char* stop = wanted ? read_field(p, end, next) : field_end(p, end);
      next += wanted;
      ++field;
      if (layout_.separator == ' ') stop = skip_blanks(stop, end);
      if (stop == end) break;
      p = skip_blanks(layout_.separator == ' ' ? stop : stop + 1, end);
      if (field >= layout_.fields) {  // what follows the last field may only be empty
        if (p == end) break;
        if (*p != layout_.separator || layout_.separator == ' ') refuse_count(count_fields(p, end, field));
      } else if (p == end) {
        ++field;  // an empty last field
        if (next < layout_.wanted.size() && layout_.wanted[next] < field) refuse_number(p, p, next);
        break;
      }
    }
    if (next < layout_.wanted.size())
      refuse(place() + ": " + layout_.labels[next], "must be there", std::to_string(field) + " columns");
    if (field < layout_.fields) refuse_count(field);
    ++row_;
  }

  const char* read_field(const char* p, const char* end, std::size_t column) {
    const char* begin = p;
    const bool quoted = p != end && *p == '"';
    if (quoted) ++p;
    const auto [value, number_end] = number(p, end, quoted);
    const char* stop = number_end;
    if (quoted && stop != p) {
      if (stop == end || *stop != '"') refuse_number(begin, end, column);
      ++stop;
    }
    const bool at_blank = stop != end && is_blank(*stop);
    if (layout_.separator != ' ') stop = skip_blanks(stop, end);
    const bool at_end = stop == end || *stop == layout_.separator || (layout_.separator == ' ' && at_blank);
    if (number_end == p || !at_end || !std::isfinite(value)) refuse_number(begin, end, column);
    columns_[column].push_back(value);
    return stop;
  }

  // The number at p; with decimal commas read from a copy, in which a point has no place.
  detail::ParsedNumber number(const char* p, const char* end, bool quoted) {
    if (layout_.decimal == '.') return detail::parse_number(p, end);
    cell_.assign(p, quoted ? find(p, end, '"') : bare_end(p, end));
    if (cell_.find('.') != std::string::npos) return {0.0, p};
    std::replace(cell_.begin(), cell_.end(), ',', '.');
    const auto [value, stop] = detail::parse_number(cell_.data(), cell_.data() + cell_.size());
    return {value, p + (stop - cell_.data())};
  }

  std::size_t count_fields(const char* p, const char* end, std::size_t field) const {
    while (p != end) {
      p = field_end(p, end);
      ++field;
      if (p != end) p = skip_blanks(layout_.separator == ' ' ? p : p + 1, end);
    }
    return field;
  }

  std::string place() const { return "line " + std::to_string(line_ - 1); }

  [[noreturn]] void refuse_count(std::size_t count) const {
    refuse(place(), "must have " + std::to_string(layout_.fields) + " columns as the header",
           std::to_string(count) + " columns");
  }

  [[noreturn]] void refuse_number(const char* begin, const char* end, std::size_t column) const {
    const char* stop = field_end(begin, end);
    while (stop != begin && is_blank(stop[-1])) --stop;
    refuse(place() + ": " + layout_.labels[column], "must be a finite number", shown(begin, stop));
  }

  void begin_call() {
    if (!whole_) refuse("NumberReader", "may not go on behind a call that failed", place());
    whole_ = false;
  }

  void require_line_length(std::size_t length) const {
    if (length > line_max)
      refuse("line " + std::to_string(line_), "must end within 16 MB", std::to_string(length) + " bytes");
  }

  TableLayout layout_;
  std::size_t first_row_, end_row_, line_, row_ = 0;
  bool whole_ = true;
  std::string carry_, cell_;
  std::vector<std::vector<double>> columns_;
};

}  // namespace cogging
