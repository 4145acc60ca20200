// Writes a table as CSV.
#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

constexpr auto unquoted =
    byte_set([](unsigned c) { return c != ',' && c != '"' && c != '\r' && c != '\n'; });

char* put_field(char* at, std::string_view text) {
  if (all_in(unquoted, text)) return std::copy(text.begin(), text.end(), at);
  *at++ = '"';
  for (const char c : text) {
    if (c == '"') *at++ = '"';
    *at++ = c;
  }
  *at++ = '"';
  return at;
}

char* put_cell(char* at, const Cell& cell) {
  return cell.kind() == Kind::text ? put_field(at, cell.text()) : put_plain(at, cell);
}

std::size_t most_chars(const Cell& cell) {
  return cell.kind() == Kind::text ? cell.text().size() * 2 + 2 : plain_chars(cell);
}

class CsvWriter final : public TableWriter {
 public:
  CsvWriter(std::span<const Column> columns, TextSink& sink)
      : columns_(columns.size()), writer_(sink) {
    std::vector<Cell> names;
    for (const Column& column : columns) names.emplace_back(column.name);
    char* at = put_line(names);
    *at++ = '\n';
    writer_.end_line(at);
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    char* const begin = writer_.begin();
    char* at = put_line(cells);
    // Many readers would not take a blank line as a row.
    if (at == begin) {
      *at++ = '"';
      *at++ = '"';
    }
    *at++ = '\n';
    return writer_.end_line(at);
  }

  bool finish() override { return writer_.flush(); }

 private:
  // Writes a line without its end, for which there is room.
  char* put_line(std::span<const Cell> cells) {
    char* at = writer_.begin();
    for (std::size_t i = 0; i < columns_; ++i) {
      if (i != 0) *at++ = ',';
      const Cell& cell = i < cells.size() ? cells[i] : absent_;
      at = put_cell(writer_.room(at, most_chars(cell) + end_chars), cell);
    }
    return at;
  }

  // A comma, or the text of a blank line and its end.
  static constexpr std::size_t end_chars = 3;

  Cell absent_;
  std::size_t columns_;
  BlockWriter writer_;
};

}  // namespace

std::unique_ptr<TableWriter> make_csv_writer(std::span<const Column> columns, TextSink& sink) {
  return std::make_unique<CsvWriter>(columns, sink);
}

}  // namespace biss::report
