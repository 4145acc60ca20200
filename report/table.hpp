// A typed table: columns declared once, rows streamed through, one writer a format. The verbs make
// the rows; only this room converts them to text.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "report/sink.hpp"

namespace biss::report {

/// The kind of value in a column or cell.
enum class Kind : std::uint8_t {
  absent,            ///< cells only: no value; empty in CSV, null in JSON, `-` for people
  unsigned_integer,  ///< up to 2^64 - 1; decimal
  signed_integer,    ///< decimal
  nanoseconds,       ///< a Picoseconds, written as nanoseconds with up to three decimals, exact
  real,              ///< a double: the fewest digits that give the same double; not finite: absent
  text,              ///< any bytes; UTF-8 if users read it
  bits,              ///< a bit string, written as one hexadecimal number (see put_hex)
  flag,              ///< 0 or 1
};

/// The names of all kinds for a reader of the columns, in the order of Kind.
inline constexpr std::array<std::string_view, 8> kind_names = {
    "", "unsigned", "signed", "time", "real", "text", "bits", "flag"};

/// One value of a row. It owns nothing: text and bits must live until row() has returned.
class Cell {
 public:
  /// Absent.
  constexpr Cell() : number_(0) {}
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool>) constexpr Cell(T value)
      : kind_(Kind::unsigned_integer), number_(value) {}
  template <std::signed_integral T>
  constexpr Cell(T value) : kind_(Kind::signed_integer), signed_(value) {}
  template <std::same_as<bool> T>
  constexpr Cell(T value) : kind_(Kind::flag), number_(value ? 1U : 0U) {}
  constexpr Cell(double value) : kind_(Kind::real), real_(value) {}
  constexpr Cell(Picoseconds value) : kind_(Kind::nanoseconds), signed_(value.count) {}
  constexpr Cell(Hertz value) : kind_(Kind::unsigned_integer), number_(value.count) {}
  constexpr Cell(std::string_view value) : kind_(Kind::text), text_(value) {}
  constexpr Cell(const char* value) : kind_(Kind::text), text_(value) {}
  Cell(const std::string& value) : kind_(Kind::text), text_(value) {}
  constexpr Cell(BitView value) : kind_(Kind::bits), bits_(value) {}
  /// Absent when there is no value.
  template <class T>
  constexpr Cell(const std::optional<T>& value) : Cell(value ? Cell(*value) : Cell()) {}

  constexpr Kind kind() const { return kind_; }
  /// \pre kind() is unsigned_integer or flag
  constexpr std::uint64_t unsigned_value() const { return number_; }
  /// \pre kind() is signed_integer
  constexpr std::int64_t signed_value() const { return signed_; }
  /// \pre kind() is real
  constexpr double real_value() const { return real_; }
  /// \pre kind() is nanoseconds
  constexpr Picoseconds time() const { return Picoseconds{signed_}; }
  /// \pre kind() is text
  constexpr std::string_view text() const { return text_; }
  /// \pre kind() is bits
  constexpr BitView bits() const { return bits_; }

 private:
  Kind kind_ = Kind::absent;
  union {
    std::uint64_t number_;
    std::int64_t signed_;
    double real_;
    std::string_view text_;
    BitView bits_;
  };
};

/// The meaning of a value for its row.
enum class Role : std::uint8_t {
  value,         ///< nothing that is good or bad
  status,        ///< text: a terminal that shows colour marks all but `ok`
  verdict,       ///< text: a state of a monitor, or a fault
  warnings,      ///< text: names with `;` between them
  error_at_0,    ///< flag
  check_at_0,    ///< flag: the status is bad too
  warning_at_0,  ///< flag
  warning_at_1,  ///< flag
};

/// The names of all roles for a reader of the columns, in the order of Role.
inline constexpr std::array<std::string_view, 8> role_names = {
    "value",      "status",     "verdict",      "warnings",
    "error_at_0", "check_at_0", "warning_at_0", "warning_at_1"};

/// A column. `name` and `kind` are the contract with scripts; all other members are for display
/// only.
struct Column {
  std::string name = {};
  Kind kind = Kind::text;
  std::string heading = {};  ///< empty: the name
  std::string unit = {};     ///< of the value as shown, printed below the heading
  /// No number and no bit string of the column has more bits; 0: not known, at most 64.
  unsigned bits = 0;
  /// Unit of the value itself, if it is not nanoseconds: an attribute in HDF5.
  std::string value_unit = {};
  /// Displayed numbers are divided by 10^shift: 6 shows hertz as MHz and nanoseconds as ms.
  unsigned shift = 0;
  /// Displayed digits after the point, rounded; nullopt: 3 more than `shift` for nanoseconds (all
  /// there is), `shift` for integers. At most 15; so is shift.
  std::optional<unsigned> places = std::nullopt;
  Role role = Role::value;
  std::string title = {};  ///< in a page: of its plot, or of the things that its role counts
  /// Place of its plot among the plots of a page, which columns may share; 0: it has none.
  unsigned plot = 0;
  /// The text is JSON; JSON lines contain it unchanged.
  bool json = false;
};

/// A column of times in nanoseconds, which a reader sees in milliseconds with four places.
inline Column time_column(std::string name, std::string heading) {
  return {.name = std::move(name),
          .kind = Kind::nanoseconds,
          .heading = std::move(heading),
          .unit = "ms",
          .shift = 6,
          .places = 4};
}

/// Writes rows in one format to a sink. Nothing is complete before finish().
class TableWriter {
 public:
  virtual ~TableWriter() = default;

  /// Takes a row, one cell a column in their order; a missing cell is absent. False if the sink has
  /// failed: the caller may stop, further rows are dropped.
  /// \pre a cell is absent or of its column's kind; a column of text takes cells of any kind
  virtual bool row(std::span<const Cell> cells) = 0;

  /// Writes the rows that are held back. False when any of the text did not reach the sink.
  virtual bool finish() = 0;
};

/// How a table is written.
enum class Format : std::uint8_t {
  table,  ///< for people: aligned, with headings, rounded as set in the columns
  csv,    ///< RFC 4180 with `\n`, a header always, absent = empty
  jsonl,  ///< one object a line, keys in the order of the columns, absent = null
  /// A waveform: a variable for each column and the event `request` at each row, at the time that the
  /// first column of nanoseconds has. Times are not negative and do not fall.
  vcd,
  hdf5,  ///< see make_hdf5_writer(); needs a FileSink
};

/// The names of all formats as a user types them, in the order of Format.
inline constexpr std::array<std::string_view, 5> format_names = {"table", "csv", "jsonl", "vcd",
                                                                 "hdf5"};

/// The format of that name; nullopt when there is none.
std::optional<Format> format_by_name(std::string_view name);

/// All of these are for `table` only.
struct TableOptions {
  bool colour = false;               ///< the terminal shows colour, and NO_COLOR is not set
  std::size_t rows_measured = 1000;  ///< rows held back to find the widths
  /// Columns of the terminal; 0: any number. Columns of the table that do not fit are left out:
  /// first columns that are empty in all measured rows, then bits, then the last ones. The first
  /// column always stays.
  std::size_t width = 0;
  /// Called once with the headings left out, if there are any.
  std::function<void(const std::vector<std::string>&)> on_left_out = nullptr;
};

/// A writer of that format. The columns are copied; the sink must outlive the writer.
/// \pre the format is not hdf5
std::unique_ptr<TableWriter> make_table_writer(Format format, std::span<const Column> columns,
                                               TextSink& sink, TableOptions options = {});

}  // namespace biss::report
