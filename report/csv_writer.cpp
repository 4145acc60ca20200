#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

void append_field(std::string& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    out.append(text);
    return;
  }
  out.push_back('"');
  for (const char c : text) {
    if (c == '"') out.push_back('"');
    out.push_back(c);
  }
  out.push_back('"');
}

void append_cell(std::string& out, const Cell& cell) {
  switch (cell.kind()) {
    case Kind::absent:
      return;
    case Kind::unsigned_integer:
    case Kind::flag:
      return append_number(out, cell.unsigned_value());
    case Kind::signed_integer:
      return append_number(out, cell.signed_value());
    case Kind::real:
      return append_number(out, cell.real_value());
    case Kind::nanoseconds:
      return append_nanoseconds(out, cell.time());
    case Kind::text:
      return append_field(out, cell.text());
    case Kind::bits:
      return append_hex(out, cell.bits());
  }
}

class CsvWriter final : public TableWriter {
 public:
  CsvWriter(std::span<const Column> columns, TextSink& sink)
      : columns_(columns.size()), writer_(sink) {
    std::string& out = writer_.block();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i != 0) out.push_back(',');
      append_field(out, columns[i].name);
    }
    out.push_back('\n');
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    std::string& out = writer_.block();
    const std::size_t begin = out.size();
    for (std::size_t i = 0; i < columns_; ++i) {
      if (i != 0) out.push_back(',');
      if (i < cells.size()) append_cell(out, cells[i]);
    }
    // A blank line would be no row at all to many readers.
    if (out.size() == begin) out.append("\"\"");
    out.push_back('\n');
    return writer_.line_done();
  }

  bool finish() override { return writer_.flush(); }

 private:
  std::size_t columns_;
  BlockWriter writer_;
};

}  // namespace

std::unique_ptr<TableWriter> make_csv_writer(std::span<const Column> columns, TextSink& sink) {
  return std::make_unique<CsvWriter>(columns, sink);
}

}  // namespace biss::report
