// Writes a table as JSON lines.
#include <cmath>
#include <vector>

#include "report/writers.hpp"

namespace biss::report {
namespace {

// Beyond it a reader that keeps numbers as doubles would change them without notice.
constexpr std::uint64_t largest_safe_integer = std::uint64_t{1} << 53U;

char* put_text(char* at, std::string_view text) { return std::copy(text.begin(), text.end(), at); }

char* put_escaped(char* at, char c) {
  constexpr std::string_view escaped = "\"\\\b\f\n\r\t";
  constexpr std::string_view letters = "\"\\bfnrt";
  constexpr std::string_view digits = "0123456789abcdef";
  const auto code = static_cast<unsigned char>(c);
  if (const std::size_t place = escaped.find(c); place != std::string_view::npos) {
    *at++ = '\\';
    *at++ = letters[place];
  } else if (code >= 0x20) {
    *at++ = c;
  } else {
    at = put_text(at, "\\u00");
    *at++ = digits[code >> 4U];
    *at++ = digits[code & 15U];
  }
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

std::size_t most_value_chars(const Cell& cell) {
  return 2 + (cell.kind() == Kind::text ? cell.text().size() * most_escaped : plain_chars(cell));
}

bool is_quoted(const Cell& cell) {
  switch (cell.kind()) {
    case Kind::unsigned_integer:
      return cell.unsigned_value() > largest_safe_integer;
    case Kind::signed_integer:
      return magnitude_of(cell.signed_value()).value > largest_safe_integer;
    case Kind::nanoseconds:
      return magnitude_of(cell.time().count).value / 1000 > largest_safe_integer;
    default:
      return cell.kind() == Kind::bits;
  }
}

char* put_value(char* at, const Cell& cell) {
  if (cell.kind() == Kind::text) return put_string(at, cell.text());
  const bool is_number = cell.kind() != Kind::real || std::isfinite(cell.real_value());
  if (cell.kind() == Kind::absent || !is_number) return put_text(at, "null");
  const bool quoted = is_quoted(cell);
  if (quoted) *at++ = '"';
  at = put_plain(at, cell);
  if (quoted) *at++ = '"';
  return at;
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
