// Finds the columns, the units and the first row of a sampled CSV of any maker.
#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <utility>

#include "capture/csv_cells.hpp"
#include "capture/decimal.hpp"
#include "capture/key_file.hpp"
#include "capture/sampled_csv.hpp"
#include "capture/samples.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

// The number of rows that are judged if only values and steps separate samples from changes. A line
// that is idle at first has a constant step for many rows; a wrong level later is an error of its
// row.
constexpr std::size_t most_rows_judged = 1'024;
constexpr std::size_t rows_of_levels = 64;

constexpr const char* expected_header =
    "the header that an oscilloscope writes: a time, or a start and an increment, and channels";
constexpr const char* expected_samples = "rows of samples after the header";

using Cells = std::vector<std::string>;

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

bool decimal_comma(char separator) { return separator != ','; }

bool is_number(std::string_view cell, char separator) {
  static constexpr std::array<std::string_view, 9> words{
      "nan", "inf", "-inf", "+inf", "infinity", "-infinity", "\xE2\x88\x9E", "-\xE2\x88\x9E", "x"};
  if (cell.empty() || cell.size() > 64) return false;
  const auto value = parse_decimal(cell, 0, decimal_comma(separator));
  if (value.ok() || value.error() == DecimalCause::out_of_range) return true;
  return std::find(words.begin(), words.end(), lower_case(cell)) != words.end();
}

// A row of samples: a number, then numbers and empty cells.
bool is_data(const Cells& cells, char separator) {
  if (!is_number(cells[0], separator)) return false;
  return std::all_of(cells.begin(), cells.end(), [separator](const std::string& cell) {
    return cell.empty() || cell.starts_with("0x") || is_number(cell, separator);
  });
}

// TDS: three columns of settings next to the first rows of samples.
bool is_old_tektronix(const Cells& cells) {
  return cells.size() >= 5 && is_number(cells[3], ',') && is_number(cells[4], ',');
}

// A row of units of PicoScope: `(ms),(V)`.
bool is_row_of_units(const Cells& cells) {
  return cells.size() > 1 && std::all_of(cells.begin(), cells.end(), [](const std::string& cell) {
           return cell.starts_with('(') && cell.ends_with(')');
         });
}

std::string_view without_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  if (text.starts_with(mark)) text.remove_prefix(mark.size());
  return text;
}

bool is_level(std::string_view cell) {
  const std::string lower = lower_case(cell);
  return cell.empty() || cell == "0" || cell == "1" || lower == "x" || lower == "z" ||
         lower == "nan";
}

// The properties of the rows under a header with a time and lines.
class ColumnRows {
 public:
  explicit ColumnRows(const std::vector<std::string_view>& rows)
      : separator_(find_separator(rows[0])) {
    bool last = false;
    std::string_view header = rows[0];
    scale_ = event_csv_time_scale(unquote(take_cell(header, separator_, last))).value_or(0);
    for (std::size_t i = 1; i < rows.size() && !enough(); ++i) {
      add(cells_of(rows[i], separator_));
      ++judged_;
    }
  }

  // Whether enough rows were judged.
  bool enough() const { return judged_ == most_rows_judged; }

  bool voltages() const {
    if (plain_) return false;
    if (numbers_.size() > 2) return 2 * analog_ >= std::min(judged_, rows_of_levels);
    constexpr EventCsvRows usual;
    const bool is_level = numbers_.count(usual.low) + numbers_.count(usual.high) != 0;
    return (numbers_.size() == 1 && !is_level) || samples();
  }

  EventCsvRows levels() const {
    EventCsvRows rows;
    if (numbers_.size() == 2) {
      rows.low = *numbers_.begin();
      rows.high = *numbers_.rbegin();
    }
    if (judged_ < least_samples || !samples()) return rows;
    const SampleSteps steps = steps_of(times_, digit_);
    rows.sample_period = steps.usual;
    rows.longest_step = steps.longest;
    rows.shortest_step = steps.shortest;
    return rows;
  }

 private:
  static constexpr std::size_t least_samples = 8;

  // Changes have no constant step, and a change is not a row that repeats the one before.
  bool samples() const {
    return 8 * repeats_ >= judged_ && !beside_ma() && steps_of(times_, digit_).constant;
  }

  // The rows of MA and SLO without the column MA: a bit has two rows. Samples have more rows for
  // each bit; if MA has two rows for each level, many such levels follow each other.
  bool beside_ma() const {
    bool any = false;
    for (const std::vector<std::size_t>& column : changes_) {
      std::size_t brief = 0;
      std::size_t in_turn = 0;
      for (std::size_t i = 1; i < column.size(); ++i) {
        const bool two = column[i] - column[i - 1] <= 2;
        brief += two ? 1U : 0U;
        in_turn = two ? in_turn + 1 : 0;
        if (in_turn == 12) return false;
      }
      any = any || (brief >= 4 && 8 * brief >= column.size());
    }
    return any;
  }

  void add(Cells cells) {
    const bool comma = decimal_comma(separator_);
    const auto time = parse_decimal(cells[0], scale_, comma);
    if (time.ok()) {
      const Picoseconds digit{last_digit_of(cells[0], scale_)};
      digit_ = times_.empty() ? digit : std::min(digit_, digit);
      times_.push_back(Picoseconds{*time});
    }
    cells[0].clear();
    if (cells == last_) ++repeats_;
    changes_.resize(std::max(changes_.size(), cells.size()));
    for (std::size_t i = 1; i < std::min(cells.size(), last_.size()); ++i) {
      if (cells[i] != last_[i]) changes_[i].push_back(judged_);
    }
    last_ = std::move(cells);
    if (judged_ < rows_of_levels) add_levels(time.ok());
  }

  void add_levels(bool numeric) {
    const bool comma = decimal_comma(separator_);
    std::size_t voltages = 0;
    std::size_t levels = 0;
    for (std::size_t i = 1; i < last_.size(); ++i) {
      const std::string& cell = last_[i];
      const auto number = parse_decimal(cell, event_csv_level_scale, comma);
      const bool level = is_level(cell);
      plain_ = plain_ && level;
      numeric = numeric && (level || is_number(cell, separator_));
      if (!cell.empty()) ++(level ? levels : voltages);
      if (number.ok()) numbers_.insert(*number);
      if (!number.ok() && !level && is_number(cell, separator_)) numbers_.insert(over_range.count);
    }
    if (numeric && voltages > levels) ++analog_;
  }

  char separator_;
  int scale_ = 0;
  std::size_t judged_ = 0;
  std::size_t analog_ = 0;   // rows with more voltages than levels
  std::size_t repeats_ = 0;  // rows like the row before
  bool plain_ = true;        // levels are written 0 and 1
  std::set<std::int64_t> numbers_;
  std::vector<Picoseconds> times_;
  Picoseconds digit_;
  std::vector<std::vector<std::size_t>> changes_;  // the rows, by column
  Cells last_;
};

// `V`, `(mV)`, `Volt`, `V DC`: nanovolts of 1, as a power of ten. Other units as volts.
int scale_of_unit(std::string_view unit) {
  while (!unit.empty() && (unit.front() == '(' || unit.front() == '[' || unit.front() == ' ')) {
    unit.remove_prefix(1);
  }
  if (unit.starts_with("mV") || unit.starts_with("mv")) return 6;
  if (unit.starts_with("uV") || unit.starts_with("\xC2\xB5V") || unit.starts_with("\xCE\xBCV")) {
    return 3;
  }
  if (unit.starts_with("nV")) return 0;
  if (unit.starts_with("kV")) return 12;
  return 9;
}

// A channel named in a header of one row: `CH1(V)`, `Channel 1 (mV)`, `CH1V`, `Channel 0`.
CsvChannel channel_of(std::size_t cell, const std::string& text) {
  CsvChannel channel{.cell = cell, .channel = {.name = text}};
  const std::size_t open = text.find_last_of("([");
  if (open != std::string::npos && open != 0 && (text.back() == ')' || text.back() == ']')) {
    channel.scale = scale_of_unit(std::string_view(text).substr(open));
    channel.channel.name = text.substr(0, text.find_last_not_of(' ', open - 1) + 1);
  } else if (text.size() > 3 && text.starts_with("CH") && text.ends_with('V')) {
    channel.channel.name = text.substr(0, text.size() - 1);
  }
  return channel;
}

// `t0 = -25s` and `tInc = 2e-06s`: the number after the equals sign.
std::string_view number_after_equals(std::string_view cell) {
  cell.remove_prefix(std::min(cell.find('='), cell.size() - 1) + 1);
  while (cell.ends_with(' ') || cell.ends_with('s')) cell.remove_suffix(1);
  while (cell.starts_with(' ')) cell.remove_prefix(1);
  return cell;
}

// Builds the layout from the rows of the beginning.
class LayoutParser {
 public:
  // Reads the rows of a maker's header; null, or a description of a valid one.
  using Take = const char* (LayoutParser::*)();
  struct Judgement {
    Likeness likeness = Likeness::no;
    Take take = nullptr;  // of the maker of the file
  };

  explicit LayoutParser(const std::vector<std::string_view>& rows) : rows_(rows) {}

  // \param rows that are neither blank nor comments
  static Judgement judge(const std::vector<std::string_view>& rows, bool whole) {
    if (rows.empty()) return {whole ? Likeness::no : Likeness::not_yet};
    const std::string_view row = rows[0];
    const Cells first = cells_of(row, find_separator(row));
    const std::string name = lower_case(first[0]);
    if (row.starts_with(';')) {
      const bool known =
          contains(row, "CSV") || contains(row, "ample rate") || contains(row, "Samplerate");
      return known ? yes(&LayoutParser::take_sigrok) : Judgement{};
    }
    if (row.starts_with("LECROY")) return yes(&LayoutParser::take_lecroy);
    if (first.size() < 2) return {};
    if (name == "x-axis") return yes(&LayoutParser::take_keysight);
    if (first[0] == "X" && first[1].starts_with("CH")) return yes(&LayoutParser::take_rigol);
    if (first[0] == "Model") return yes(&LayoutParser::take_tektronix);
    if (first[0] == "Record Length") {
      return yes(is_old_tektronix(first) ? &LayoutParser::take_tektronix_old
                                         : &LayoutParser::take_siglent);
    }
    if (first[0] == "Source" && first[1].starts_with("CH")) return yes(&LayoutParser::take_siglent);
    if (contains(row, "tInc") && contains(row, "t0")) return yes(&LayoutParser::take_rigol_memory);
    if (name.starts_with("time") || name.starts_with("zeit") || name.starts_with("temps")) {
      return judge_time(rows, first, whole);
    }
    return {};
  }

  tl::expected<SampledCsvLayout, const char*> parse() {
    std::vector<std::string_view> judged;
    for (const std::string_view row : rows_) {
      if (!is_csv_comment(row)) judged.push_back(trim_cell(row, ','));
    }
    const Take take = judge(judged, true).take;
    if (take == nullptr) return tl::unexpected(expected_header);
    const bool sigrok = take == &LayoutParser::take_sigrok;
    const bool old_tektronix = take == &LayoutParser::take_tektronix_old;
    if (!sigrok) layout_.separator = find_separator(judged[0]);
    if (!old_tektronix && !find_samples(sigrok)) return tl::unexpected(expected_samples);
    if (const char* const wrong = (this->*take)()) return tl::unexpected(wrong);
    if (layout_.channels.empty()) return tl::unexpected(expected_header);
    layout_.header_rows = samples_;
    if (layout_.sample_rate.count == 0 && layout_.step_femtoseconds != 0) {
      layout_.sample_period = Picoseconds{(layout_.step_femtoseconds + 999) / 1'000};
      constexpr std::int64_t femtoseconds_of_second = 1'000'000'000'000'000;
      const std::int64_t rate = femtoseconds_of_second / layout_.step_femtoseconds;
      const bool whole = femtoseconds_of_second % layout_.step_femtoseconds == 0;
      if (whole && rate <= hertz_max.count)
        layout_.sample_rate = Hertz{static_cast<std::uint32_t>(rate)};
    }
    return std::move(layout_);
  }

 private:
  static Judgement yes(Take take) { return {Likeness::yes, take}; }

  static Judgement judge_time(const std::vector<std::string_view>& rows, const Cells& first,
                              bool whole) {
    const std::string name = lower_case(first[0]);
    if (rows.size() == 1) return {whole ? Likeness::no : Likeness::not_yet};
    const Cells second = cells_of(rows[1], find_separator(rows[0]));
    if (is_row_of_units(second)) return yes(&LayoutParser::take_picoscope);
    if (name == "time" && second[0] == "Second") return yes(&LayoutParser::take_rigol);
    if (!event_csv_time_scale(name)) return {};
    const ColumnRows columns(rows);
    if (!columns.enough() && !whole) return {Likeness::not_yet, &LayoutParser::take_columns};
    return {columns.voltages() ? Likeness::yes : Likeness::no, &LayoutParser::take_columns};
  }

  Cells cells(std::size_t row) const { return cells_of(rows_[row], layout_.separator); }
  bool find_samples(bool sigrok) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (is_csv_comment(rows_[i])) continue;
      if (sigrok && (rows_[i].starts_with(';') || is_sigrok_remark(rows_[i]))) {
        continue;
      }
      if (is_data(cells(i), layout_.separator)) {
        samples_ = i;
        return true;
      }
      header_.push_back(i);
    }
    return false;
  }

  const char* take_keysight() {
    if (header_.size() != 2 || !lower_case(cells(header_[1])[0]).starts_with("second")) {
      return expected_header;
    }
    return take_named(cells(header_[0]), cells(header_[1]));
  }

  const char* take_picoscope() {
    const auto scale = event_csv_time_scale("time " + cells(last_header())[0]);
    if (header_.size() != 2 || !scale) return expected_header;
    layout_.time_scale = *scale;
    return take_named(cells(header_[0]), cells(header_[1]));
  }

  const char* take_tektronix() {
    if (lower_case(cells(last_header())[0]) != "time") return expected_header;
    return take_named(cells(last_header()));
  }

  void take_start(std::string_view text) {
    const auto start = parse_decimal(text, 12);
    if (start.ok()) layout_.start = Picoseconds{*start};
    any_start_ = any_start_ || start.ok();
  }

  void take_step(std::string_view text) {
    const auto step = parse_decimal(text, 15);
    if (step.ok() && *step > 0) layout_.step_femtoseconds = *step;
  }

  const char* take_rigol() {
    if (header_.size() != 2) return expected_header;
    const Cells names = cells(header_[0]);
    const Cells units = cells(header_[1]);
    layout_.time_cell = 0;
    for (std::size_t i = 1; i < names.size() && i < units.size(); ++i) {
      if (names[i] == "Start") {
        take_start(units[i]);
      } else if (names[i] == "Increment") {
        take_step(units[i]);
      } else if (lower_case(units[i]).starts_with("volt")) {
        std::string name = names[i];
        if (name.starts_with("X(") && name.ends_with(')')) name = name.substr(2, name.size() - 3);
        layout_.channels.push_back({.cell = i, .channel = {.name = std::move(name)}});
      }
    }
    if (units[0] == "Second") {
      layout_.step_femtoseconds = 0;
    } else if (!any_start_ || layout_.step_femtoseconds == 0) {
      return "Start and Increment in the second row";
    }
    return nullptr;
  }

  const char* take_rigol_memory() {
    if (header_.size() != 1) return expected_header;
    const Cells names = cells(header_[0]);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].empty()) continue;
      if (names[i].starts_with("t0")) {
        take_start(number_after_equals(names[i]));
      } else if (names[i].starts_with("tInc")) {
        take_step(number_after_equals(names[i]));
      } else {
        layout_.channels.push_back(channel_of(i, names[i]));
      }
    }
    if (!any_start_ || layout_.step_femtoseconds == 0) return "t0 = TIME and tInc = TIME";
    return nullptr;
  }

  const char* take_siglent() {
    const Cells units = cells(last_header());
    if (!units[0].starts_with("Second")) return expected_header;
    Cells names;
    for (const std::size_t row : header_) {
      if (cells(row)[0] == "Source") names = cells(row);
    }
    names.resize(units.size());
    for (std::size_t i = 1; i < units.size(); ++i) {
      if (units[i].empty()) {
        names[i].clear();
      } else if (names[i].empty()) {
        names[i] = "CH" + std::to_string(i);
      }
    }
    return take_named(names, units);
  }

  const char* take_lecroy() {
    for (const std::size_t row : header_) {
      const Cells segments = cells(row);
      if (segments[0] == "Segments" && segments.size() > 1 && segments[1] != "1") {
        return "one segment; export the segments one by one";
      }
    }
    if (!cells(last_header())[0].starts_with("Time")) return expected_header;
    return take_named(cells(last_header()));
  }

  const char* take_sigrok() {
    Hertz rate = parse_sample_rate(comment("Samplerate: "));
    if (rate.count == 0) rate = parse_sample_rate(comment("Sample rate: "));
    if (rate.count == 0) return "the sample rate in a comment, as in ; Samplerate: 100 MHz";
    // Old versions write no names above the samples.
    const Cells heads = header_.empty() ? Cells(cells(samples_).size()) : cells(last_header());
    const std::string time_name = lower_case(heads[0]);
    const bool has_time = time_name.starts_with("time") || time_name.ends_with("seconds");
    take_rate(rate, time_name);
    layout_.skips_remarks = true;
    if (has_time) layout_.time_cell = 0;
    if (!has_time) layout_.index_step = 1;
    std::string list = comment("): ");
    const Cells names = list.empty() ? Cells() : cells_of(list, ',');
    const Cells sample = cells(samples_);
    const std::size_t first = has_time ? 1 : 0;
    for (std::size_t i = first; i < heads.size() && i < sample.size(); ++i) {
      if (heads[i].empty() && !header_.empty()) continue;
      if (heads[i] == "Trigger") continue;
      const std::size_t k = i - first;
      CsvChannel channel{
          .cell = i, .channel = {.name = heads[i]}, .scale = scale_of_unit(heads[i])};
      if (k < names.size()) channel.channel.name = names[k];
      if (channel.channel.name.empty()) channel.channel.name = "D" + std::to_string(k);
      // A unit, or a voltage in the first rows.
      bool analog = heads[i] == "V" || contains(heads[i], "V DC") || contains(heads[i], "V AC");
      for (std::size_t row = samples_; row < rows_.size() && heads[i] != "logic"; ++row) {
        if (is_csv_comment(rows_[row]) || is_sigrok_remark(rows_[row])) continue;
        const Cells values = cells(row);
        const bool level = i >= values.size() || values[i].empty() || values[i] == "0" ||
                           values[i] == "1" || lower_case(values[i]) == "x";
        analog = analog || !level;
      }
      channel.channel.logic = !analog;
      layout_.channels.push_back(std::move(channel));
    }
    return nullptr;
  }

  const char* take_named(const Cells& names, const Cells& units = {}) {
    layout_.time_cell = 0;
    for (std::size_t i = 1; i < names.size(); ++i) {
      if (names[i].empty()) continue;
      CsvChannel channel = units.empty() ? channel_of(i, names[i])
                                         : CsvChannel{.cell = i, .channel = {.name = names[i]}};
      if (i < units.size()) channel.scale = scale_of_unit(units[i]);
      layout_.channels.push_back(std::move(channel));
    }
    return nullptr;
  }

  const char* take_columns() {
    const Cells names = cells(header_[0]);
    const auto scale = event_csv_time_scale(names[0]);
    if (!scale) return expected_header;
    layout_.time_scale = *scale;
    return take_named(names);
  }

  const char* take_tektronix_old() {
    std::string name = "CH1";
    for (const std::string_view row : rows_) {
      const Cells settings = cells_of(row, ',');
      if (settings[0] == "Source" && settings.size() > 1 && !settings[1].empty()) {
        name = settings[1];
      }
    }
    layout_.time_cell = 3;
    layout_.channels.push_back({.cell = 4, .channel = {.name = name}});
    return nullptr;
  }

  // The text after `key` in a comment of sigrok or DSView.
  std::string comment(std::string_view key) const {
    for (const std::string_view row : rows_) {
      if (!row.starts_with(';')) continue;
      const std::size_t at = row.find(key);
      if (at == std::string::npos) continue;
      return std::string(trim_cell(row.substr(at + key.size()), ','));
    }
    return {};
  }

  // sigrok gives times in the largest unit that is at most a sample period, as the index times the
  // whole units of a period: at 3 MHz 333, 666, 999 ns.
  void take_rate(Hertz rate, std::string_view time_name) {
    layout_.sample_period = longest_period(rate);
    layout_.sample_rate = rate;
    if (time_name.ends_with("(s)")) return;  // DSView
    layout_.rate = rate;
    std::uint64_t units = 1'000;
    while (units < rate.count) units *= 1'000;
    layout_.index_step = static_cast<std::int64_t>(units / rate.count);
  }

  std::size_t last_header() const { return header_[header_.size() - 1]; }

  const std::vector<std::string_view>& rows_;
  SampledCsvLayout layout_;
  bool any_start_ = false;
  // Rows before the samples that are neither blank nor comments; the first sample.
  std::vector<std::size_t> header_;
  std::size_t samples_ = 0;
};

// The rows that are judged. A last row without a line end may be cut off. It counts only at the end
// of the file, and only if there is at most one other row.
std::vector<std::string_view> rows_of(std::string_view head, bool whole) {
  head = without_mark(head);
  std::vector<std::string_view> rows;
  while (!head.empty() && rows.size() <= most_rows_judged) {
    const std::size_t end = head.find('\n');
    if (end == std::string_view::npos && (!whole || rows.size() > 1)) break;
    const std::string_view row = head.substr(0, end);
    if (!is_csv_comment(row)) rows.push_back(trim_cell(row, ','));
    head.remove_prefix(end == std::string_view::npos ? head.size() : end + 1);
  }
  return rows;
}

}  // namespace

Likeness looks_like_sampled_csv(std::string_view head, bool whole) {
  return LayoutParser::judge(rows_of(head, whole), whole).likeness;
}

EventCsvRows event_csv_rows(std::string_view head) {
  const auto rows = rows_of(head, true);
  return rows.empty() ? EventCsvRows() : ColumnRows(rows).levels();
}

bool is_sigrok_remark(std::string_view row) {
  return !row.empty() && row.front() >= 'A' && row.find(": ") != std::string_view::npos;
}

tl::expected<SampledCsvLayout, const char*> parse_sampled_csv_layout(
    const std::vector<std::string_view>& rows) {
  return LayoutParser(rows).parse();
}

}  // namespace biss::capture
