#include "capture/analog.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace biss::capture {
namespace {

// Held until the levels are known.
constexpr std::size_t first_rows_judged = 4'096;
constexpr std::size_t most_samples_held = std::size_t{1} << 20U;
constexpr unsigned changes_of_sure_levels = 16;
// A swing below this part of the largest one is crosstalk or noise.
constexpr std::int64_t least_part_of_swing = 16;
constexpr std::int64_t hysteresis_part = 5;
constexpr Threshold logic_threshold{millivolts(500), {}};
// If the file does not give the time between samples, it is measured in this many rows.
constexpr std::size_t rows_of_period = 1'024;

bool is_voltage(Nanovolts sample) {
  return sample <= over_range && sample >= Nanovolts{-over_range.count};
}

// Limited to the range of a duration.
Picoseconds elapsed(Picoseconds from, Picoseconds to) {
  const auto ps = static_cast<std::uint64_t>(to.count) - static_cast<std::uint64_t>(from.count);
  constexpr auto longest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return Picoseconds{static_cast<std::int64_t>(std::min(ps, longest))};
}

constexpr const char* expected_step =
    "samples at a constant step, or changes between two levels only";
constexpr Picoseconds endless{std::numeric_limits<std::int64_t>::max()};

// A line and the columns that it is made of.
struct AnalogLine {
  std::size_t plus = 0;
  std::optional<std::size_t> minus;
  bool logic = false;
};

Nanovolts voltage_of(const AnalogLine& line, const Nanovolts* row) {
  const Nanovolts plus = row[line.plus];
  if (!line.minus || !is_voltage(plus)) return plus;
  const Nanovolts minus = row[*line.minus];
  if (!is_voltage(minus)) return minus;
  const std::int64_t difference = plus.count - minus.count;
  return Nanovolts{std::clamp(difference, -over_range.count, over_range.count)};
}

// Turns the samples of one line into edges.
class Slicer {
 public:
  // Without a threshold the level is unknown; a logic channel has its own.
  Slicer(const AnalogLine& line, std::optional<Threshold> threshold) : interpolate_(!line.logic) {
    if (line.logic) threshold = logic_threshold;
    if (!threshold) return;
    blind_ = false;
    upper_ = threshold->centre.count + threshold->hysteresis.count / 2;
    lower_ = threshold->centre.count - threshold->hysteresis.count / 2;
  }

  void set_longest_step(Picoseconds step) { longest_step_ = step; }

  // Nothing has changed up to this time.
  void skip_to(Picoseconds time) {
    has_last_ = false;
    last_time_ = time;
  }

  // Appends the edges that this sample makes. `before` is the time of the row before it.
  void push(Picoseconds before, Picoseconds time, Nanovolts sample, wire::LineIndex line,
            std::vector<wire::Edge>& edges) {
    if (elapsed(last_time_, time) > longest_step_ && level_ != no_level && level_ != unknown) {
      edges.push_back({before, line, wire::Level::unknown});
      level_ = unknown;
    }
    if (sample == no_sample) {
      has_last_ = false;
      return;
    }
    const std::uint8_t level = level_of(sample);
    if (level != level_) {
      edges.push_back({crossing(time, sample, level), line, static_cast<wire::Level>(level)});
      level_ = level;
    }
    has_last_ = is_inside(sample);
    last_time_ = time;
    last_ = sample.count;
  }

 private:
  static constexpr auto low = static_cast<std::uint8_t>(wire::Level::low);
  static constexpr auto high = static_cast<std::uint8_t>(wire::Level::high);
  static constexpr auto unknown = static_cast<std::uint8_t>(wire::Level::unknown);

  static bool is_inside(Nanovolts sample) {
    return sample < over_range && sample > Nanovolts{-over_range.count};
  }

  std::uint8_t level_of(Nanovolts sample) const {
    if (blind_ || sample == bad_sample) return unknown;
    if (sample.count >= upper_) return high;
    if (sample.count < lower_) return low;
    return level_ == no_level ? unknown : level_;
  }

  // Linear between the last sample and this one.
  Picoseconds crossing(Picoseconds time, Nanovolts sample, std::uint8_t level) const {
    const bool changes = (level_ == low && level == high) || (level_ == high && level == low);
    if (!interpolate_ || !has_last_ || !changes || !is_inside(sample)) return time;
    const std::int64_t limit = level == high ? upper_ : lower_;
    const double share =
        static_cast<double>(limit - last_) / static_cast<double>(sample.count - last_);
    const double step = static_cast<double>(elapsed(last_time_, time).count);
    const std::int64_t offset = std::llround(std::clamp(share, 0.0, 1.0) * step);
    return std::min(time, last_time_ + picoseconds(offset));
  }

  bool blind_ = true;
  bool interpolate_;
  std::int64_t upper_ = 0;
  std::int64_t lower_ = 0;
  std::uint8_t level_ = no_level;
  bool has_last_ = false;
  Picoseconds last_time_;
  std::int64_t last_ = 0;
  Picoseconds longest_step_ = endless;
};

// The two channels whose names `pair` joins; nothing if there are none, or if `pair` can be divided
// in two ways.
std::optional<std::pair<std::size_t, std::size_t>> divide(
    const std::string& pair, const std::vector<AnalogChannel>& channels) {
  const auto index_of = [&](std::string_view name) {
    std::size_t index = 0;
    while (index < channels.size() && (channels[index].name != name || channels[index].logic)) {
      ++index;
    }
    return index;
  };
  std::optional<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t dash = pair.find('-'); dash != std::string::npos;
       dash = pair.find('-', dash + 1)) {
    const std::size_t plus = index_of(std::string_view(pair).substr(0, dash));
    const std::size_t minus = index_of(std::string_view(pair).substr(dash + 1));
    if (plus == channels.size() || minus == channels.size() || plus == minus) continue;
    if (found) return std::nullopt;
    found = {plus, minus};
  }
  return found;
}

unsigned changes_between(SignalLevels levels, std::span<const Nanovolts> samples) {
  const std::int64_t middle = levels.low.count + (levels.high.count - levels.low.count) / 2;
  unsigned changes = 0;
  bool high = samples[0].count > middle;
  for (const Nanovolts sample : samples) {
    if ((sample.count > middle) == high || !is_voltage(sample)) continue;
    ++changes;
    high = !high;
  }
  return changes;
}

std::int64_t swing_of(const SignalLevels& levels) { return levels.high.count - levels.low.count; }

Threshold middle_of(const SignalLevels& levels) {
  const std::int64_t swing = swing_of(levels);
  return {Nanovolts{levels.low.count + swing / 2}, Nanovolts{swing / hysteresis_part}};
}

class AnalogSource final : public StepSource {
 public:
  explicit AnalogSource(std::unique_ptr<AnalogSamples> samples)
      : samples_(std::move(samples)), columns_(samples_->channels().size()) {}

  // Finds the lines and their thresholds; returns the cause of a failure.
  std::optional<CaptureError> open(const AnalogOptions& options) {
    if (const auto error = find_lines(options.differentials)) return error;
    if (const auto error = measure_steps()) return error;
    if (rows_held() == 0 && samples_ended_) {
      if (sample_error_) return sample_error_;
      return CaptureError{.cause = CaptureCause::empty};
    }
    std::optional<CaptureError> error;
    if (any_analog_ && !options.threshold) {
      error = measure();
    } else {
      for (const AnalogLine& line : analog_lines_) slicers_.emplace_back(line, options.threshold);
    }
    for (std::size_t i = 0; !error && i < longest_of_line_.size(); ++i) {
      slicers_[i].set_longest_step(longest_of_line_[i]);
    }
    return error;
  }

  Picoseconds sample_period() const override { return sample_period_; }
  Hertz sample_rate() const override { return samples_->sample_rate(); }
  bool is_analog() const override { return any_analog_; }

 private:
  std::optional<CaptureError> find_lines(const std::vector<Differential>& differentials) {
    const std::vector<AnalogChannel>& channels = samples_->channels();
    std::vector<bool> taken(channels.size());
    std::vector<AnalogLine> pairs;
    for (const Differential& differential : differentials) {
      const auto divided = divide(differential.pair, channels);
      if (!divided) return CaptureError{.cause = CaptureCause::no_such_channel};
      pairs.push_back({divided->first, divided->second, false});
      taken[divided->first] = taken[divided->second] = true;
    }
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (taken[i]) continue;
      analog_lines_.push_back({i, std::nullopt, channels[i].logic});
      lines.push_back(channels[i].name);
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      analog_lines_.push_back(pairs[i]);
      lines.push_back(differentials[i].name);
    }
    set_lines(std::move(lines));
    for (const AnalogLine& line : analog_lines_) (line.logic ? any_logic_ : any_analog_) = true;
    return std::nullopt;
  }

  std::optional<CaptureError> measure() {
    const std::size_t most_rows = most_samples_held / columns_;
    std::size_t wanted = first_rows_judged;
    for (;;) {
      const bool more = hold_more(wanted);
      const bool last_try = !more || wanted >= most_rows;
      if (const auto levels = judge(last_try)) {
        set_thresholds(*levels);
        return std::nullopt;
      }
      if (!more) {
        if (sample_error_) return sample_error_;
        return CaptureError{.cause = CaptureCause::no_two_levels};
      }
      if (wanted >= most_rows) {
        drop_held();
      } else {
        wanted = std::min(4 * wanted, most_rows);
      }
    }
  }

  // The levels of each line in the rows held; nothing if more rows are needed to be sure.
  std::optional<std::vector<std::optional<SignalLevels>>> judge(bool last_try) {
    std::vector<std::optional<SignalLevels>> levels;
    bool any = false;
    std::vector<Nanovolts> voltages(rows_held());
    for (const AnalogLine& line : analog_lines_) {
      levels.emplace_back();
      if (line.logic) continue;
      for (std::size_t i = 0; i < rows_held(); ++i) voltages[i] = voltage_of(line, row(i));
      levels.back() = estimate_levels(voltages);
      any = any || levels.back().has_value();
      if (last_try) continue;
      if (!levels.back()) return std::nullopt;
      if (changes_between(*levels.back(), voltages) < changes_of_sure_levels) return std::nullopt;
    }
    // A file with logic channels is worth reading without its analog ones.
    if (!any && !(last_try && any_logic_)) return std::nullopt;
    return levels;
  }

  // Reads until that many rows are held; false if the samples end before.
  bool hold_more(std::size_t rows) {
    while (!samples_ended_ && rows_held() < rows) {
      fresh_.clear();
      sample_error_ = samples_->next(fresh_);
      samples_ended_ = sample_error_.has_value() || fresh_.times.empty();
      const std::size_t before = rows_held();
      rows_.times.insert(rows_.times.end(), fresh_.times.begin(), fresh_.times.end());
      rows_.values.insert(rows_.values.end(), fresh_.values.begin(), fresh_.values.end());
      refuse_short_steps(before);
    }
    return rows_held() >= rows;
  }

  // Voltages must have a constant step up to the end. The rows before a shorter step are delivered.
  void refuse_short_steps(std::size_t from) {
    for (std::size_t i = std::max<std::size_t>(from, 1); i < rows_held(); ++i) {
      const Picoseconds each = elapsed(rows_.times[i - 1], rows_.times[i]);
      if (each == Picoseconds{} || each >= shortest_step_) continue;
      rows_.times.resize(i);
      rows_.values.resize(i * columns_);
      sample_error_ = CaptureError{.cause = CaptureCause::malformed, .expected = expected_step};
      samples_ended_ = true;
    }
  }

  // No line changes in the rows held: the first quarter and the last one, in which a burst may have
  // begun, are enough.
  void drop_held() {
    if (first_row_.times.empty()) {
      first_row_.times.assign(1, rows_.times.front());
      first_row_.values.assign(row(0), row(1));
    }
    const auto dropped = static_cast<std::ptrdiff_t>(rows_held() - rows_held() / 4);
    for (auto time = rows_.times.begin(); time != rows_.times.begin() + dropped; ++time) {
      hole_dropped_ = hole_dropped_ || elapsed(time[0], time[1]) > longest_step_;
    }
    rows_.times.erase(rows_.times.begin(), rows_.times.begin() + dropped);
    rows_.values.erase(rows_.values.begin(),
                       rows_.values.begin() + dropped * static_cast<std::ptrdiff_t>(columns_));
  }

  void set_thresholds(const std::vector<std::optional<SignalLevels>>& levels) {
    // The largest swing of plain lines and of differentials.
    std::array<std::optional<SignalLevels>, 2> largest;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      auto& best = largest[analog_lines_[i].minus ? 1 : 0];
      if (levels[i] && (!best || swing_of(*levels[i]) > swing_of(*best))) best = levels[i];
    }
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const AnalogLine& line = analog_lines_[i];
      const auto& best = largest[line.minus ? 1 : 0];
      const bool own = levels[i] && swing_of(*levels[i]) >= swing_of(*best) / least_part_of_swing;
      std::optional<Threshold> threshold;
      if (own || best) threshold = middle_of(own ? *levels[i] : *best);
      // A differential without a change is compared with 0 V.
      if (!threshold && line.minus) threshold = Threshold{{}, default_hysteresis};
      slicers_.emplace_back(line, threshold);
    }
  }

  std::optional<CaptureError> measure_steps() {
    sample_period_ = samples_->sample_period();
    if (!samples_->time_digit() && sample_period_ != Picoseconds{}) return std::nullopt;
    hold_more(rows_of_period);
    const std::size_t judged = std::min(rows_held(), rows_of_period);
    if (const auto digit = samples_->time_digit()) {
      const SampleSteps steps = steps_of(std::span(rows_.times).first(judged), *digit);
      if (!steps.constant && any_analog_) {
        return CaptureError{.cause = CaptureCause::malformed, .expected = expected_step};
      }
      // Rows of logic channels that never repeat the row before are changes.
      if (any_analog_ || (steps.constant && 8 * repeats(judged) >= judged)) {
        longest_step_ = steps.longest;
        shortest_step_ = steps.shortest;
        refuse_short_steps(1);
        for (const AnalogLine& line : analog_lines_) {
          longest_of_line_.push_back(longest_step_of(line, *digit));
        }
      }
    }
    if (sample_period_ != Picoseconds{}) return std::nullopt;
    for (std::size_t i = 1; i < judged; ++i) {
      const Picoseconds step = elapsed(rows_.times[i - 1], rows_.times[i]);
      if (step <= longest_step_) sample_period_ = std::max(sample_period_, step);
    }
    return std::nullopt;
  }

  // How many rows equal the row before.
  std::size_t repeats(std::size_t rows) const {
    std::size_t found = 0;
    for (std::size_t i = 1; i < rows; ++i)
      found += std::equal(row(i - 1), row(i), row(i)) ? 1U : 0U;
    return found;
  }

  // A line whose samples have no constant step has no holes.
  Picoseconds longest_step_of(const AnalogLine& line, Picoseconds digit) const {
    std::vector<Picoseconds> times;
    for (std::size_t i = 0; i < std::min(rows_held(), rows_of_period); ++i) {
      if (voltage_of(line, row(i)) != no_sample) times.push_back(rows_.times[i]);
    }
    const SampleSteps steps = steps_of(times, digit);
    return steps.constant ? steps.longest : endless;
  }

  void step() override {
    if (next_row_ == rows_held() && first_row_.times.empty()) {
      if (sample_error_) return fail(*sample_error_);
      if (samples_ended_) return finish();
      rows_.clear();
      next_row_ = 0;
      hold_more(1);
      return;
    }
    const auto slice = [this](const SampleRows& rows, std::size_t index) {
      row_edges_.clear();
      for (std::size_t i = 0; i < analog_lines_.size(); ++i) {
        const Nanovolts voltage =
            voltage_of(analog_lines_[i], rows.values.data() + index * columns_);
        slicers_[i].push(end_time_, rows.times[index], voltage, static_cast<wire::LineIndex>(i),
                         row_edges_);
      }
      end_time_ = rows.times[index];
      if (row_edges_.size() > 1) {
        std::stable_sort(row_edges_.begin(), row_edges_.end(),
                         [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
      }
      for (const wire::Edge& edge : row_edges_) block_.push(edge);
    };
    if (!first_row_.times.empty()) {
      slice(first_row_, 0);
      first_row_.clear();
      for (Slicer& slicer : slicers_) slicer.skip_to(hole_dropped_ ? end_time_ : rows_.times[0]);
    }
    while (next_row_ < rows_held() && !block_.full()) slice(rows_, next_row_++);
  }

  const Nanovolts* row(std::size_t index) const { return rows_.values.data() + index * columns_; }
  std::size_t rows_held() const { return rows_.times.size(); }

  std::unique_ptr<AnalogSamples> samples_;
  std::size_t columns_;
  std::vector<AnalogLine> analog_lines_;
  bool any_analog_ = false;
  bool any_logic_ = false;
  std::vector<Slicer> slicers_;
  Picoseconds sample_period_;
  Picoseconds longest_step_ = endless;  // between two rows
  Picoseconds shortest_step_{};
  std::vector<Picoseconds> longest_of_line_;  // between two samples

  // Rows that are not sliced yet, from next_row_ on, and the rows that follow them.
  SampleRows rows_;
  SampleRows fresh_;
  std::size_t next_row_ = 0;
  bool samples_ended_ = false;
  std::optional<CaptureError> sample_error_;
  // A row before those that are held; rows between were dropped, and perhaps there was a hole.
  SampleRows first_row_;
  bool hole_dropped_ = false;

  std::vector<wire::Edge> row_edges_;
};

}  // namespace

SampleSteps steps_of(std::span<const Picoseconds> times, Picoseconds digit) {
  SampleSteps found{.usual = {}, .longest = endless, .shortest = {}, .constant = true};
  std::vector<Picoseconds> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(elapsed(times[i - 1], times[i]));
  if (steps.empty()) return found;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  found.usual = *middle;
  const auto differ_by_more = [&](std::int64_t most) {
    return static_cast<std::size_t>(std::count_if(
        steps.begin(), steps.end(),
        [&](Picoseconds step) { return std::abs(step.count - found.usual.count) > most; }));
  };
  // Rounding shows in the steps, unless only a few of them differ.
  const bool rounded = 16 * differ_by_more(0) > steps.size();
  const std::int64_t tolerance = std::max(found.usual.count / 2, rounded ? digit.count : 0);
  found.shortest = found.usual / 4 - (rounded ? digit : Picoseconds{});
  // Two rows may have the same time.
  const auto is_short = [&](Picoseconds each) {
    return each != Picoseconds{} && each < found.shortest;
  };
  // Lost samples never make a step shorter; a change of SLO between two edges of MA makes two short
  // steps.
  const Picoseconds brief = 3 * found.shortest;
  const auto briefer = std::count_if(steps.begin(), steps.end(), [&](Picoseconds each) {
    return each != Picoseconds{} && each < brief;
  });
  found.constant = 4 * differ_by_more(tolerance) <= steps.size() &&
                   32 * static_cast<std::size_t>(briefer) <= steps.size() &&
                   std::none_of(steps.begin(), steps.end(), is_short);
  if (tolerance < endless.count - found.usual.count) {
    found.longest = found.usual + picoseconds(tolerance);
  }
  return found;
}

Opened open_analog(std::unique_ptr<AnalogSamples> samples, const AnalogOptions& options) {
  auto source = std::make_unique<AnalogSource>(std::move(samples));
  if (const auto error = source->open(options)) return tl::unexpected(*error);
  return source;
}

namespace {

constexpr std::size_t histogram_bins = 1'024;
constexpr std::uint64_t least_samples_of_class = 8;
constexpr Nanovolts least_swing = millivolts(100);
// Distance of the classes in units of the sum of their standard deviations: Gaussian noise, divided
// at its middle, has 1.3; a sine has 2.1; a square wave with slow edges 4 and more.
constexpr double least_separation = 1.6;

// Samples of a signal by voltage.
class Histogram {
 public:
  explicit Histogram(std::vector<Nanovolts> samples) {
    std::erase_if(samples, [](Nanovolts sample) {
      return sample >= over_range || sample <= Nanovolts{-over_range.count};
    });
    if (samples.empty()) return;
    const auto [least, greatest] = std::minmax_element(samples.begin(), samples.end());
    least_ = static_cast<double>(least->count);
    greatest_ = static_cast<double>(greatest->count);
    if (greatest_ <= least_) return;
    for (const Nanovolts sample : samples) {
      const double share = (static_cast<double>(sample.count) - least_) / (greatest_ - least_);
      const auto bin = static_cast<std::size_t>(share * (histogram_bins - 1) + 0.5);
      ++counts_[std::min(bin, histogram_bins - 1)];
    }
  }

  double swing() const { return greatest_ - least_; }
  Nanovolts voltage(std::size_t bin) const {
    const double above = static_cast<double>(bin) * (greatest_ - least_);
    return Nanovolts{std::llround(least_ + above / (histogram_bins - 1))};
  }
  const std::array<std::uint64_t, histogram_bins>& counts() const { return counts_; }

 private:
  double least_ = 0;
  double greatest_ = 0;
  std::array<std::uint64_t, histogram_bins> counts_{};
};

// The bins first…end of a histogram.
struct SampleClass {
  double count = 0;
  double mean = 0;
  double deviation = 0;
  std::size_t median = 0;
};

SampleClass class_of(const Histogram& histogram, std::size_t first, std::size_t end) {
  SampleClass result;
  double sum = 0;
  double squares = 0;
  for (std::size_t bin = first; bin < end; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    const auto at = static_cast<double>(bin);
    result.count += n;
    sum += n * at;
    squares += n * at * at;
  }
  if (result.count == 0) return result;
  result.mean = sum / result.count;
  result.deviation = std::sqrt(std::max(0.0, squares / result.count - result.mean * result.mean));
  double below = 0;
  for (result.median = first; result.median + 1 < end; ++result.median) {
    below += static_cast<double>(histogram.counts()[result.median]);
    if (2 * below >= result.count) break;
  }
  return result;
}

// The beginning of the upper class: the division with the largest variance between the classes.
std::size_t division_of(const Histogram& histogram) {
  double all = 0;
  double all_sum = 0;
  for (std::size_t bin = 0; bin < histogram_bins; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    all += n;
    all_sum += n * static_cast<double>(bin);
  }
  double count = 0;
  double sum = 0;
  double best = -1;
  std::size_t division = 1;
  for (std::size_t bin = 0; bin + 1 < histogram_bins; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    count += n;
    sum += n * static_cast<double>(bin);
    if (count == 0 || count == all) continue;
    const double distance = sum / count - (all_sum - sum) / (all - count);
    const double between = count * (all - count) * distance * distance;
    if (between <= best) continue;
    best = between;
    division = bin + 1;
  }
  return division;
}

}  // namespace

std::optional<SignalLevels> estimate_levels(std::span<const Nanovolts> samples) {
  const Histogram histogram({samples.begin(), samples.end()});
  if (histogram.swing() < static_cast<double>(least_swing.count)) return std::nullopt;
  const std::size_t division = division_of(histogram);
  const SampleClass low = class_of(histogram, 0, division);
  const SampleClass high = class_of(histogram, division, histogram_bins);
  if (std::min(low.count, high.count) < static_cast<double>(least_samples_of_class)) {
    return std::nullopt;
  }
  if (high.mean - low.mean < least_separation * (low.deviation + high.deviation)) {
    return std::nullopt;
  }
  const SignalLevels levels{histogram.voltage(low.median), histogram.voltage(high.median)};
  if (levels.high.count - levels.low.count < least_swing.count) return std::nullopt;
  return levels;
}

}  // namespace biss::capture
