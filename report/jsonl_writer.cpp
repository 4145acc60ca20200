// Writes a table as JSON lines.
#include <cmath>
#include <vector>

#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

// Beyond it a reader that keeps numbers as doubles would change them without a word.
constexpr std::uint64_t largest_safe_integer = std::uint64_t{1} << 53U;

char* put_text(char* at, std::string_view text) { return std::copy(text.begin(), text.end(), at); }

char* put_escaped(char* at, char c) {
  constexpr std::string_view digits = "0123456789abcdef";
  switch (c) {
    case '"':
      return put_text(at, "\\\"");
    case '\\':
      return put_text(at, "\\\\");
    case '\b':
      return put_text(at, "\\b");
    case '\f':
      return put_text(at, "\\f");
    case '\n':
      return put_text(at, "\\n");
    case '\r':
      return put_text(at, "\\r");
    case '\t':
      return put_text(at, "\\t");
    default:
      break;
  }
  const auto code = static_cast<unsigned char>(c);
  if (code >= 0x20) {
    *at++ = c;
    return at;
  }
  at = put_text(at, "\\u00");
  *at++ = digits[code >> 4U];
  *at++ = digits[code & 15U];
  return at;
}

constexpr auto unescaped =
    byte_set([](unsigned c) { return c >= 0x20 && c < 0x80 && c != '"' && c != '\\'; });
constexpr std::size_t most_escaped = 6;

// JSON is UTF-8: a byte that is not part of any becomes U+FFFD.
char* put_string(char* at, std::string_view text) {
  *at++ = '"';
  if (all_in(unescaped, text)) {
    at = put_text(at, text);
    text = {};
  }
  while (!text.empty()) {
    const CodePoint point = front_code_point(text);
    if (point.bytes == 1 && point.valid) {
      at = put_escaped(at, text.front());
    } else {
      at = put_text(at, point.valid ? text.substr(0, point.bytes) : "\xEF\xBF\xBD");
    }
    text.remove_prefix(point.bytes);
  }
  *at++ = '"';
  return at;
}

template <class Put>
char* put_safely(char* at, std::uint64_t integer_part, Put put) {
  const bool quoted = integer_part > largest_safe_integer;
  if (quoted) *at++ = '"';
  at = put(at);
  if (quoted) *at++ = '"';
  return at;
}

std::size_t most_value_chars(const Cell& cell) {
  if (cell.kind() == Kind::text) return cell.text().size() * most_escaped + 2;
  return 2 + (cell.kind() == Kind::bits ? hex_chars(cell.bits()) : number_chars);
}

char* put_value(char* at, const Cell& cell) {
  switch (cell.kind()) {
    case Kind::absent:
      break;
    case Kind::flag:
    case Kind::unsigned_integer:
      return put_safely(at, cell.unsigned_value(),
                        [&](char* to) { return put_number(to, cell.unsigned_value()); });
    case Kind::signed_integer:
      return put_safely(at, magnitude_of(cell.signed_value()).value,
                        [&](char* to) { return put_number(to, cell.signed_value()); });
    case Kind::real:
      if (!std::isfinite(cell.real_value())) break;
      return put_number(at, cell.real_value());
    case Kind::nanoseconds:
      return put_safely(at, magnitude_of(cell.time().count).value / 1000,
                        [&](char* to) { return put_nanoseconds(to, cell.time()); });
    case Kind::text:
      return put_string(at, cell.text());
    case Kind::bits:
      *at++ = '"';
      at = put_hex(at, cell.bits());
      *at++ = '"';
      return at;
  }
  return put_text(at, "null");
}

class JsonlWriter final : public TableWriter {
 public:
  JsonlWriter(std::span<const Column> columns, TextSink& sink) : writer_(sink) {
    for (const Column& column : columns) {
      std::string key(column.name.size() * most_escaped + 4, '\0');
      char* at = key.data();
      *at++ = keys_.empty() ? '{' : ',';
      at = put_string(at, column.name);
      *at++ = ':';
      key.resize(static_cast<std::size_t>(at - key.data()));
      keys_.push_back(std::move(key));
      raw_.push_back(column.json);
    }
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    char* at = writer_.begin();
    if (keys_.empty()) *at++ = '{';
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const Cell& cell = i < cells.size() ? cells[i] : absent_;
      // With the two characters that end the line.
      at = writer_.room(at, keys_[i].size() + most_value_chars(cell) + 2);
      at = put_text(at, keys_[i]);
      at = raw_[i] && cell.kind() == Kind::text ? put_text(at, cell.text()) : put_value(at, cell);
    }
    return writer_.end_line(put_text(at, "}\n"));
  }

  bool finish() override { return writer_.flush(); }

 private:
  Cell absent_;
  std::vector<bool> raw_;
  std::vector<std::string> keys_;  // `{"name":` or `,"name":`
  BlockWriter writer_;
};

}  // namespace

std::unique_ptr<TableWriter> make_jsonl_writer(std::span<const Column> columns, TextSink& sink) {
  return std::make_unique<JsonlWriter>(columns, sink);
}

}  // namespace biss::report
