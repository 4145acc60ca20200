#include <cmath>
#include <vector>

#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

// Beyond it a reader that keeps numbers as doubles would change them without a word.
constexpr std::uint64_t largest_safe_integer = std::uint64_t{1} << 53U;

void append_escaped(std::string& out, char c) {
  constexpr std::string_view digits = "0123456789abcdef";
  switch (c) {
    case '"':
      return void(out.append("\\\""));
    case '\\':
      return void(out.append("\\\\"));
    case '\b':
      return void(out.append("\\b"));
    case '\f':
      return void(out.append("\\f"));
    case '\n':
      return void(out.append("\\n"));
    case '\r':
      return void(out.append("\\r"));
    case '\t':
      return void(out.append("\\t"));
    default:
      break;
  }
  const auto code = static_cast<unsigned char>(c);
  if (code >= 0x20) return out.push_back(c);
  out.append("\\u00");
  out.push_back(digits[code >> 4U]);
  out.push_back(digits[code & 15U]);
}

// JSON is UTF-8: a byte that is not part of any becomes U+FFFD.
void append_string(std::string& out, std::string_view text) {
  out.push_back('"');
  while (!text.empty()) {
    const CodePoint point = front_code_point(text);
    if (point.bytes == 1 && point.valid) {
      append_escaped(out, text.front());
    } else {
      out.append(point.valid ? text.substr(0, point.bytes) : "\xEF\xBF\xBD");
    }
    text.remove_prefix(point.bytes);
  }
  out.push_back('"');
}

template <class Append>
void append_safely(std::string& out, std::uint64_t integer_part, Append append) {
  const bool quoted = integer_part > largest_safe_integer;
  if (quoted) out.push_back('"');
  append();
  if (quoted) out.push_back('"');
}

void append_value(std::string& out, const Cell& cell) {
  switch (cell.kind()) {
    case Kind::absent:
      return void(out.append("null"));
    case Kind::unsigned_integer:
    case Kind::flag:
      return append_safely(out, cell.unsigned_value(),
                           [&] { append_number(out, cell.unsigned_value()); });
    case Kind::signed_integer:
      return append_safely(out, magnitude_of(cell.signed_value()).value,
                           [&] { append_number(out, cell.signed_value()); });
    case Kind::real:
      if (!std::isfinite(cell.real_value())) return void(out.append("null"));
      return append_number(out, cell.real_value());
    case Kind::nanoseconds:
      return append_safely(out, magnitude_of(cell.time().count).value / 1000,
                           [&] { append_nanoseconds(out, cell.time()); });
    case Kind::text:
      return append_string(out, cell.text());
    case Kind::bits:
      out.push_back('"');
      append_hex(out, cell.bits());
      out.push_back('"');
      return;
  }
}

class JsonlWriter final : public TableWriter {
 public:
  JsonlWriter(std::span<const Column> columns, TextSink& sink) : writer_(sink) {
    for (const Column& column : columns) {
      std::string& key = keys_.emplace_back(keys_.empty() ? "{" : ",");
      append_string(key, column.name);
      key.push_back(':');
    }
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    std::string& out = writer_.block();
    if (keys_.empty()) out.push_back('{');
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      out.append(keys_[i]);
      append_value(out, i < cells.size() ? cells[i] : Cell());
    }
    out.append("}\n");
    return writer_.line_done();
  }

  bool finish() override { return writer_.flush(); }

 private:
  std::vector<std::string> keys_;  // `{"name":` or `,"name":`
  BlockWriter writer_;
};

}  // namespace

std::unique_ptr<TableWriter> make_jsonl_writer(std::span<const Column> columns, TextSink& sink) {
  return std::make_unique<JsonlWriter>(columns, sink);
}

}  // namespace biss::report
