// Writes a table as VCD, with a variable for each column.
#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <vector>

#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

constexpr unsigned word_bits = 64;

// The lowest `count` bits as digits.
void append_bits(std::string& out, std::uint64_t word, unsigned count) {
  std::array<char, word_bits> digits;
  for (unsigned i = 0; i < count; ++i) {
    digits[i] = static_cast<char>('0' + (word >> (count - 1 - i) & 1U));
  }
  out.append(digits.data(), count);
}

// As GTKWave reads strings: a backslash and three octal digits for a character that would end the
// value.
void append_string_value(std::string& out, std::string_view text) {
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte > 0x20 && byte < 0x7F && c != '\\') {
      out.push_back(c);
      continue;
    }
    out.push_back('\\');
    for (const unsigned shift : {6U, 3U, 0U}) {
      out.push_back(static_cast<char>('0' + (byte >> shift & 7U)));
    }
  }
}

struct VariableType {
  std::string_view name;
  char prefix;     ///< of a value; 0: none
  unsigned width;  ///< 0: the bits of the column
};

// In the order of Kind.
constexpr std::array<VariableType, kind_names.size()> types{{{"string", 's', 1},
                                                             {"integer", 'b', 0},
                                                             {"integer", 'b', 0},
                                                             {"real", 'r', word_bits},
                                                             {"real", 'r', word_bits},
                                                             {"string", 's', 1},
                                                             {"wire", 'b', 0},
                                                             {"wire", '\0', 1}}};

// A column as a variable. Absent is x, and NaN if the variable is a real number.
class Variable {
 public:
  Variable(const Column& column, std::string id)
      : name_(column.name),
        kind_(column.kind),
        bits_(column.bits == 0 ? word_bits : column.bits),
        id_(std::move(id)) {}

  std::string declaration() const {
    std::string text = "$var " + std::string(type().name) + ' ';
    append_number(text, std::uint64_t{width()});
    return text + ' ' + id_ + ' ' + name_ + " $end\n";
  }

  /// Appends the value if it differs from the previous row.
  void put(std::string& out, const Cell& cell) {
    next_.clear();
    static const Cell no_value;
    append_value(next_, cell.kind() == kind_ ? cell : no_value);
    if (next_ == last_) return;
    out += next_;
    if (kind_ != Kind::flag) out += ' ';
    out += id_;
    out += '\n';
    last_.swap(next_);
  }

 private:
  const VariableType& type() const { return types[static_cast<std::size_t>(kind_)]; }

  unsigned width() const {
    if (type().width != 0) return type().width;
    // An integer has a sign.
    return kind_ == Kind::unsigned_integer ? bits_ + 1 : bits_;
  }

  void append_value(std::string& out, const Cell& cell) const {
    const char prefix = type().prefix;
    if (prefix == '\0') {
      out.push_back(cell.kind() == Kind::absent ? 'x' : cell.unsigned_value() != 0 ? '1' : '0');
      return;
    }
    out.push_back(prefix);
    if (prefix == 'r') {
      append_plain(out, cell);
      if (out.back() == prefix) out += "nan";
      return;
    }
    if (prefix == 'b') return append_vector(out, cell);
    if (cell.kind() == Kind::text) append_string_value(out, cell.text());
  }

  void append_vector(std::string& out, const Cell& cell) const {
    switch (cell.kind()) {
      case Kind::unsigned_integer: {
        // Without the zeros in front that a reader adds itself.
        const std::uint64_t value = cell.unsigned_value();
        const auto count = word_bits - static_cast<unsigned>(std::countl_zero(value | 1U));
        return append_bits(out, value, count);
      }
      case Kind::signed_integer:
        // All bits, because a reader would extend a shorter value with zeros.
        return append_bits(out, static_cast<std::uint64_t>(cell.signed_value()), bits_);
      case Kind::bits:
        if (!cell.bits().empty()) return append_all(out, cell.bits());
        break;
      default:
        break;
    }
    out.push_back('x');
  }

  static void append_all(std::string& out, BitView bits) {
    for (std::size_t at = 0; at < bits.size_bits(); at += word_bits) {
      const auto count =
          static_cast<unsigned>(std::min<std::size_t>(bits.size_bits() - at, word_bits));
      append_bits(out, bits.word(at, count), count);
    }
  }

  std::string name_;
  Kind kind_;
  unsigned bits_;
  std::string id_;
  std::string last_;
  std::string next_;
};

std::string id_of(std::size_t number) {
  constexpr char first = '!';
  constexpr std::size_t characters = 94;
  std::string id;
  for (++number; number != 0; number /= characters) {
    id.push_back(static_cast<char>(first + number % characters));
  }
  return id;
}

class VcdWriter final : public TableWriter {
 public:
  VcdWriter(std::span<const Column> columns, TextSink& sink) : writer_(sink) {
    const auto is_time = [](const Column& column) { return column.kind == Kind::nanoseconds; };
    time_ = static_cast<std::size_t>(std::find_if(columns.begin(), columns.end(), is_time) -
                                     columns.begin());
    std::string head = "$timescale 1 ps $end\n$scope module decode $end\n$var event 1 " + id_of(0) +
                       " request $end\n";
    for (std::size_t i = 0; i < columns.size(); ++i) {
      variables_.emplace_back(columns[i], id_of(i + 1));
      if (i != time_) head += variables_.back().declaration();
    }
    head += "$upscope $end\n$enddefinitions $end\n$dumpvars\n";
    put_values(head, {});
    head += "$end\n";
    writer_.write_line(head);
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    if (time_ < cells.size() && cells[time_].kind() == Kind::nanoseconds) {
      now_ = std::max(now_, cells[time_].time().count);
    }
    line_ = '#';
    append_number(line_, now_);
    line_ += "\n1" + id_of(0) + '\n';
    put_values(line_, cells);
    return writer_.write_line(line_);
  }

  bool finish() override { return writer_.flush(); }

 private:
  void put_values(std::string& out, std::span<const Cell> cells) {
    for (std::size_t i = 0; i < variables_.size(); ++i) {
      if (i != time_) variables_[i].put(out, i < cells.size() ? cells[i] : Cell());
    }
  }

  std::size_t time_ = 0;
  std::int64_t now_ = 0;
  std::vector<Variable> variables_;
  std::string line_;
  BlockWriter writer_;
};

}  // namespace

std::unique_ptr<TableWriter> make_vcd_writer(std::span<const Column> columns, TextSink& sink) {
  return std::make_unique<VcdWriter>(columns, sink);
}

}  // namespace biss::report
