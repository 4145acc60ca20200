#include "capture/sampled_csv.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "capture/csv_cells.hpp"
#include "capture/decimal.hpp"
#include "capture/samples.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

// The rows that the layout is read from, and how many bytes of them are kept.
constexpr std::size_t beginning_rows = 64;
constexpr std::size_t beginning_bytes = 131'072;
constexpr std::size_t rows_of_block = 4'096;

constexpr const char* expected_digits =
    "times with enough digits to tell two samples apart; export more digits";

std::optional<Nanovolts> voltage_word(std::string_view cell) {
  const std::string word = lower_case(cell);
  if (word == "nan" || word == "x") return bad_sample;
  std::string_view rest = word;
  const bool negative = rest.starts_with('-');
  if (negative || rest.starts_with('+')) rest.remove_prefix(1);
  if (rest != "inf" && rest != "infinity" && rest != "\xE2\x88\x9E") return std::nullopt;
  return negative ? Nanovolts{-over_range.count} : over_range;
}

// The time of the sample with this index; nothing if it is out of range.
std::optional<Picoseconds> time_of(const SampledCsvLayout& layout, std::uint64_t index) {
  if (layout.rate.count != 0) {
    const SampleClock clock(layout.rate);
    return index > clock.last_index() ? std::nullopt : std::optional(clock.time_of(index));
  }
  constexpr auto greatest = std::numeric_limits<std::int64_t>::max();
  const auto step = static_cast<std::uint64_t>(layout.step_femtoseconds);
  if (index > (static_cast<std::uint64_t>(greatest) - 500) / step) return std::nullopt;
  const auto offset = static_cast<std::int64_t>((index * step + 500) / 1'000);
  if (layout.start.count > greatest - offset) return std::nullopt;
  return layout.start + picoseconds(offset);
}

// Rows of text as rows of samples.
class SampledCsvReader final : public AnalogSamples {
 public:
  explicit SampledCsvReader(std::unique_ptr<ByteSource> bytes)
      : window_(std::move(bytes), TextWindow::Cut::lines) {}

  // Reads the header; the cause when there is none.
  std::optional<CaptureError> open() {
    if (const auto error = read_beginning()) return error;
    std::vector<std::string_view> rows;
    rows.reserve(beginning_.size());
    for (const Row& row : beginning_) rows.push_back(row.text);
    auto layout = parse_sampled_csv_layout(rows);
    if (!layout) {
      if (late_error_) return late_error_;
      for (const Row& row : beginning_) {
        if (has_cr_inside(row.text)) {
          return CaptureError{CaptureCause::malformed, row.line, 1, expected_line_ends};
        }
      }
      const bool cut = beginning_.back().cut;
      return CaptureError{cut ? CaptureCause::truncated : CaptureCause::malformed,
                          cut ? beginning_.back().line : beginning_.front().line, 1,
                          layout.error()};
    }
    return use_layout(std::move(*layout));
  }

  const std::vector<AnalogChannel>& channels() const override { return channels_; }
  Picoseconds sample_period() const override { return layout_.sample_period; }
  Hertz sample_rate() const override { return layout_.sample_rate; }
  std::optional<Picoseconds> time_digit() const override { return digit_; }
  std::optional<CaptureError> next(SampleRows& rows) override {
    for (; next_beginning_ < beginning_.size(); ++next_beginning_) {
      const Row& row = beginning_[next_beginning_];
      const std::uint64_t line = std::exchange(line_, row.line);
      read_row(row.text, row.cut, rows);
      if (error_) return error_;
      line_ = line;
    }
    if (!rows.times.empty()) return std::nullopt;
    error_ = late_error_;
    while (rows.times.size() < rows_of_block && !error_) {
      if (window_.begin() == window_.end()) {
        if (!rows.times.empty()) break;
        const auto more = window_.next();
        if (!more) error_ = more.error();
        if (!more || !*more) break;
      }
      const char* const row = window_.begin();
      const char* const end = find_or_end(row, window_.end(), '\n');
      window_.advance(end + 1);
      ++line_;
      read_row(text_between(row, end), window_.unterminated(), rows);
    }
    return error_;
  }

 private:
  struct Row {
    std::string text;
    std::uint64_t line;
    bool cut;  // the text ended without a line feed
  };

  std::optional<CaptureError> read_beginning() {
    std::size_t bytes = 0;
    bool any_text = false;
    beginning_.reserve(beginning_rows);
    while (beginning_.size() < beginning_rows && bytes < beginning_bytes) {
      if (window_.begin() == window_.end()) {
        const auto more = window_.next();
        if (!more && beginning_.empty()) return more.error();
        if (!more) late_error_ = more.error();
        if (!more || !*more) break;
      }
      const char* const row = window_.begin();
      const char* const end = find_or_end(row, window_.end(), '\n');
      const std::string_view text = text_between(row, end);
      if (text.size() > max_token_bytes && !has_cr_inside(text)) {
        if (beginning_.empty()) return CaptureError{CaptureCause::token_too_long, line_ + 1, 1};
        break;
      }
      window_.advance(end + 1);
      ++line_;
      const std::string_view trimmed = trim_cell(text, ',');
      if (trimmed.empty()) continue;
      any_text = true;
      // There may be thousands of them before the first sample.
      const bool sigrok = !beginning_.empty() && beginning_[0].text.starts_with(';');
      if (sigrok && is_sigrok_remark(trimmed)) continue;
      bytes += text.size();
      beginning_.push_back({std::string(text), line_, window_.unterminated()});
    }
    if (!any_text) return CaptureError{.cause = CaptureCause::empty};
    return std::nullopt;
  }

  std::optional<CaptureError> use_layout(SampledCsvLayout layout) {
    layout_ = std::move(layout);
    if (layout_.channels.size() > max_analog_channels) {
      return CaptureError{CaptureCause::too_many_lines, beginning_[0].line, 1};
    }
    const auto need_cell = [this](std::size_t cell) {
      channel_of_cell_.resize(std::max(channel_of_cell_.size(), cell + 1), unused);
    };
    for (const CsvChannel& channel : layout_.channels) {
      need_cell(channel.cell);
      channel_of_cell_[channel.cell] = channels_.size();
      channels_.push_back(channel.channel);
    }
    if (layout_.time_cell) need_cell(*layout_.time_cell);
    values_.resize(channels_.size());
    next_beginning_ = layout_.header_rows;
    return std::nullopt;
  }

  void read_row(std::string_view row, bool cut, SampleRows& rows) {
    const bool wrong_end = has_cr_inside(row);
    if (wrong_end || row.size() > max_token_bytes) {
      stop(wrong_end ? CaptureCause::malformed : CaptureCause::token_too_long, 0,
           wrong_end ? expected_line_ends : nullptr);
      return;
    }
    const std::string_view trimmed = trim_cell(row, layout_.separator);
    if (is_csv_comment(trimmed)) return;
    if (trimmed.front() == ';' && layout_.separator != ';') return;
    if (layout_.skips_remarks && is_sigrok_remark(trimmed)) return;
    Picoseconds time;
    if (!read_cells(row, cut) || !read_time(time_text_, time_column_, time)) {
      // A number that was cut off is not a fault of the row.
      if (cut && error_->cause == CaptureCause::malformed) error_->cause = CaptureCause::truncated;
      return;
    }
    if (!check_order(time)) return;
    if (rows_read_++ < beginning_rows) {
      const std::int64_t digit =
          layout_.by_index() ? 0 : last_digit_of(time_text_, layout_.time_scale);
      digit_ = std::min(digit_, picoseconds(digit));
    }
    rows.times.push_back(time);
    rows.values.insert(rows.values.end(), values_.begin(), values_.end());
  }

  bool read_cells(std::string_view row, bool cut) {
    std::size_t at = 0;
    for (std::size_t cell = 0; cell < channel_of_cell_.size(); ++cell) {
      if (at > row.size()) {
        return stop(cut ? CaptureCause::truncated : CaptureCause::malformed, row.size(),
                    "a value for every channel");
      }
      const std::size_t end = std::min(row.find(layout_.separator, at), row.size());
      const std::string_view text =
          without_quotes(trim_cell(row.substr(at, end - at), layout_.separator));
      if (layout_.time_cell == cell) {
        time_text_ = text;
        time_column_ = at;
      } else if (channel_of_cell_[cell] != unused) {
        if (!read_channel(text, channel_of_cell_[cell], at)) return false;
      }
      at = end + 1;
    }
    return true;
  }

  bool read_time(std::string_view cell, std::size_t column, Picoseconds& time) {
    const bool by_index = layout_.by_index();
    if (by_index && !layout_.time_cell) return take_time(time_of(layout_, rows_read_), time);
    const int scale = by_index ? 0 : layout_.time_scale;
    const auto number = parse_decimal(cell, scale, layout_.separator != ',');
    if (!number.ok()) {
      const bool range = number.error() == DecimalCause::out_of_range;
      return stop(range ? CaptureCause::time_out_of_range : CaptureCause::malformed, column,
                  range ? nullptr : "a decimal number as the time");
    }
    if (!by_index) return take_time(Picoseconds{*number}, time);
    if (*number < 0 || *number % layout_.index_step != 0) {
      return stop(CaptureCause::malformed, column, "the number of the sample");
    }
    const auto index = static_cast<std::uint64_t>(*number / layout_.index_step);
    return take_time(time_of(layout_, index), time);
  }

  bool take_time(std::optional<Picoseconds> found, Picoseconds& time) {
    time = found.value_or(time);
    return found || stop(CaptureCause::time_out_of_range, 0);
  }

  bool read_channel(std::string_view cell, std::size_t channel, std::size_t column) {
    Nanovolts& value = values_[channel];
    const CsvChannel& kind = layout_.channels[channel];
    value = no_sample;
    if (cell.empty()) return true;
    if (kind.channel.logic) {
      const std::size_t level =
          cell.size() == 1 ? std::string_view("01xXzZ").find(cell[0]) : std::string_view::npos;
      if (level == std::string_view::npos) {
        return stop(CaptureCause::malformed, column, "a level: 0 or 1");
      }
      value = level > 1 ? bad_sample : level == 1 ? millivolts(1'000) : Nanovolts{};
      return true;
    }
    const auto number = parse_decimal(cell, kind.scale, layout_.separator != ',');
    if (number.ok()) {
      value = Nanovolts{std::clamp(*number, -over_range.count, over_range.count)};
    } else if (number.error() == DecimalCause::out_of_range) {
      // SCPI writes 9.9E37 for infinity and 9.91E37 for no number.
      value = bad_sample;
    } else if (const auto word = voltage_word(cell)) {
      value = *word;
    } else {
      return stop(CaptureCause::malformed, column, "a decimal number");
    }
    return true;
  }

  bool check_order(Picoseconds time) {
    if (!last_time_ || time > *last_time_) {
      repeated_ = false;
    } else if (time < *last_time_) {
      return stop(CaptureCause::time_backwards, time_column_);
    } else if (std::exchange(repeated_, true)) {
      return stop(CaptureCause::malformed, time_column_, expected_digits);
    }
    last_time_ = time;
    return true;
  }

  bool stop(CaptureCause cause, std::size_t column, const char* expected = nullptr) {
    error_ = CaptureError{cause, line_, column + 1, expected};
    return false;
  }

  static constexpr std::size_t unused = std::numeric_limits<std::size_t>::max();

  TextWindow window_;
  SampledCsvLayout layout_;
  std::vector<AnalogChannel> channels_;
  // The channel of each cell that is read; the time, too, is read from its cell.
  std::vector<std::size_t> channel_of_cell_;

  std::vector<Row> beginning_;
  std::size_t next_beginning_ = 0;
  std::uint64_t line_ = 0;
  std::uint64_t rows_read_ = 0;
  Picoseconds digit_{std::numeric_limits<std::int64_t>::max()};  // the smallest of the first rows
  std::vector<Nanovolts> values_;
  std::string_view time_text_;
  std::size_t time_column_ = 0;
  std::optional<Picoseconds> last_time_;
  bool repeated_ = false;
  std::optional<CaptureError> error_;
  // After the rows of the beginning.
  std::optional<CaptureError> late_error_;
};

}  // namespace

Opened open_sampled_csv(std::unique_ptr<ByteSource> bytes, const AnalogOptions& options) {
  auto reader = std::make_unique<SampledCsvReader>(std::move(bytes));
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return open_analog(std::move(reader), options);
}

}  // namespace biss::capture
