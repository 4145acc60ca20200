#include "verbs/settings/exchange.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>

#include "biss/frame/format_text.hpp"
#include "device/nearest.hpp"
#include "device/quantity.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {
namespace {

using Number = std::optional<std::uint64_t>;
/// The value of each row of a master.
using Values = std::vector<Number>;

// ---- The terms of masters.txt

/// The bits of a channel in the order lead, multiturn, gap, singleturn, bits after the position.
struct BitLayout {
  explicit BitLayout(const ChannelFormat& of) : channel(of) {
    const biss::Field low = of.position.present() ? of.position : of.singleturn;
    const biss::Field high = of.multiturn.present() ? of.multiturn : low;
    multiturn = of.multiturn.bits;
    singleturn = low.bits;
    after = low.shift;
    lead = of.data_bits - high.shift - high.bits;
    gap = multiturn == 0 ? 0 : high.shift - low.shift - low.bits;
    for (int shift = std::min(after, 2) - 1; shift >= 0; --shift) {
      const bool is_error = of.error.present && of.error.shift == shift;
      const bool is_warning = of.warning.present && of.warning.shift == shift;
      status += is_error     ? (of.error.active_high ? 'E' : 'e')
                : is_warning ? (of.warning.active_high ? 'W' : 'w')
                             : 'p';
    }
    const auto in_status = [this](const FlagField& flag) {
      return !flag.present || flag.shift < std::min(after, 2);
    };
    in_order = low.present() && gap >= 0 && !of.life_counter.present() && in_status(of.error) &&
               in_status(of.warning);
  }
  int tail() const { return std::max(after - 2, 0); }
  bool usual() const {
    return channel.crc.polynomial == default_polynomial(channel.crc.width_bits);
  }

  ChannelFormat channel;
  int lead = 0;
  int multiturn = 0;
  int gap = 0;
  int singleturn = 0;
  int after = 0;
  /// A letter for each of the last two bits before the CRC: e, w, E, W as in a format, p padding.
  std::string status;
  bool in_order = true;
};

Number number_of_bits(int value) { return static_cast<std::uint64_t>(value); }
Number power_of_2(int bits) {
  return bits < 64 ? Number(std::uint64_t{1} << static_cast<unsigned>(bits)) : std::nullopt;
}

/// A term and its value for a frame; nothing: the row keeps its fallback.
struct Term {
  std::string_view name;
  Number (*value)(const BitLayout& frame);
};
using F = const BitLayout&;
constexpr auto terms = std::to_array<Term>({
    {"multiturn", [](F f) { return number_of_bits(f.multiturn); }},
    {"singleturn", [](F f) { return number_of_bits(f.singleturn); }},
    {"position", [](F f) { return number_of_bits(f.multiturn + f.singleturn); }},
    {"counts_multiturn", [](F f) { return power_of_2(f.multiturn); }},
    {"counts_singleturn", [](F f) { return power_of_2(f.singleturn); }},
    {"lead", [](F f) { return number_of_bits(f.lead); }},
    {"tail", [](F f) { return number_of_bits(f.tail()); }},
    {"payload", [](F f) { return number_of_bits(f.channel.data_bits - f.after + f.tail()); }},
    {"first_multiturn", [](F f) { return f.multiturn == 0 ? Number() : number_of_bits(f.lead); }},
    {"first_singleturn", [](F f) { return number_of_bits(f.lead + f.multiturn + f.gap); }},
    {"after_bits", [](F f) { return number_of_bits(f.after); }},
    {"after_all", [](F f) { return number_of_bits(f.after + f.channel.crc.width_bits); }},
    {"data", [](F f) { return number_of_bits(f.channel.data_bits); }},
    {"data_minus_1", [](F f) { return number_of_bits(f.channel.data_bits - 1); }},
    {"frame", [](F f) { return number_of_bits(static_cast<int>(f.channel.total_bits())); }},
    {"status_off", [](F f) { return number_of_bits(f.status == "ew" ? 0 : 1); }},
    {"status_high", [](F f) { return number_of_bits(f.status == "EW" ? 1 : 0); }},
    {"gray", [](F f) { return number_of_bits(f.channel.coded() ? 1 : 0); }},
    {"polynomial", [](F f) { return Number(f.channel.crc.polynomial); }},
    {"polynomial_half", [](F f) { return Number(f.channel.crc.polynomial >> 1U); }},
    {"crc_width", [](F f) { return number_of_bits(f.channel.crc.width_bits); }},
    {"crc_usual", [](F f) { return number_of_bits(f.usual() ? 0 : 1); }},
    {"crc_field",
     [](F f) {
       const CrcSpec& crc = f.channel.crc;
       return Number(f.usual() ? crc.width_bits : crc.polynomial >> 1U);
     }},
    {"crc_inverted",
     [](F f) {
       return f.channel.crc.present() ? number_of_bits(f.channel.crc.inverted) : Number();
     }},
    {"crc_start", [](F f) { return Number(f.channel.crc.start); }},
    // Users may choose other values than these.
    {"counts_free", [](F f) { return power_of_2(f.multiturn + f.singleturn); }},
    {"turns_free", [](F f) { return number_of_bits(f.multiturn > 0 ? 1 : 0); }},
});

const Term* find_term(std::string_view name) {
  const auto term = std::find_if(terms.begin(), terms.end(),
                                 [name](const Term& each) { return each.name == name; });
  return term == terms.end() ? nullptr : &*term;
}

// The row has a fact of the format.
bool is_format(const Parameter& row) {
  return find_term(row.term) != nullptr && !row.term.ends_with("_free");
}

// ---- From values to a format

/// The format that values describe; what they leave open is as in most encoders.
class FormatMaker {
 public:
  /// \param polynomial of a CRC that has no usual one of its width
  FormatMaker(const Master& master, const Values& values, std::uint32_t polynomial = 0)
      : master_(master), values_(values), polynomial_(polynomial) {}

  tl::expected<FrameFormat, std::string> make() const {
    const std::string text = text_of_format();
    const auto format = parse_format(text);
    if (format.ok()) return *format;
    return tl::unexpected(text.empty()
                              ? std::string("the numbers of bits do not fit together, or are not "
                                            "in this table")
                              : fmt::format("{}: {}", text, text_of(format.error().mistake)));
  }

  std::uint32_t crc_polynomial() const {
    if (const auto full = get("polynomial")) return static_cast<std::uint32_t>(*full);
    const auto half = get("crc_usual") == 1 ? get("crc_field") : get("polynomial_half");
    if (half) return *half == 0 ? 0U : static_cast<std::uint32_t>(*half) << 1U | 1U;
    const auto width = get("crc_field") ? get("crc_field") : get("crc_width");
    if (!width) return 0x43U;
    const std::uint32_t usual = default_polynomial(static_cast<unsigned>(*width));
    return usual != 0 ? usual : polynomial_;
  }

 private:
  std::string text_of_format() const {
    const std::uint32_t polynomial = crc_polynomial();
    const std::int64_t width = polynomial == 0 ? 0 : std::int64_t{std::bit_width(polynomial)} - 1;
    const std::int64_t turns_given = bits("multiturn", "counts_multiturn").value_or(-1);
    auto singleturn = bits("singleturn", "counts_singleturn");
    std::int64_t turns = std::max<std::int64_t>(turns_given, 0);
    std::int64_t lead = get("lead").value_or(0);
    std::int64_t gap = 0;
    std::int64_t after = get("after_bits").value_or(2 + get("tail").value_or(0));
    if (const auto all = get("after_all")) after = *all - width;
    if (const auto first = get("first_singleturn")) {
      lead = turns > 0 ? get("first_multiturn").value_or(0) : *first;
      gap = *first - lead - turns;
      after = get("payload").value_or(0) - *first - singleturn.value_or(0) + 2;
    }
    auto position = get("position");
    if (const auto payload = get("payload")) position = *payload - lead - (after - 2);
    if (const auto data = get("data")) position = *data - after - lead;
    if (const auto data = get("data_minus_1")) position = *data + 1 - after;
    if (const auto frame = get("frame"); frame && !position) position = *frame - width - after;
    if (position && singleturn && turns_given < 0) turns = *position - *singleturn;
    if (!singleturn) singleturn = position.value_or(0) - turns;
    if (*singleturn < 1 || turns < 0 || lead < 0 || gap < 0 || after < 0) return {};
    std::vector<std::string> items;
    const std::string gray = get("gray") == 1 ? ":gray" : "";
    const auto add = [&items](std::string_view name, std::int64_t count, std::string_view suffix) {
      if (count > 0) items.push_back(fmt::format("{}{}{}", name, count, suffix));
    };
    add("pad", lead, "");
    add("mt", turns, gray);
    add("pad", gap, "");
    add(turns > 0 ? "st" : "pos", *singleturn, gray);
    add("pad", after - 2, "");
    const bool high = get("status_high") == 1;
    if (after >= 1) items.emplace_back(high ? "E" : "nE");
    if (after >= 2) items.emplace_back(high ? "W" : "nW");
    if (const auto crc = get("crc_width"); polynomial == 0 && crc && *crc != 0) {
      items.push_back(fmt::format("crc{}", *crc));  // an error
    } else if (polynomial != 0) {
      items.push_back(fmt::format("crc{}:0x{:X}:0x{:X}{}", width, polynomial,
                                  get("crc_start").value_or(0),
                                  get("crc_inverted").value_or(1) == 1 ? "" : ":plain"));
    }
    return fmt::format("{}", fmt::join(items, ","));
  }

  std::optional<std::int64_t> get(std::string_view term) const {
    const Parameter* const row = master_.find(term);
    if (row == nullptr) return std::nullopt;
    const Number& value = values_[static_cast<std::size_t>(row - master_.parameters.data())];
    return value ? std::optional(static_cast<std::int64_t>(*value)) : std::nullopt;
  }

  std::optional<std::int64_t> bits(std::string_view term, std::string_view counts) const {
    const auto count = get(counts);
    return count ? std::countr_zero(static_cast<std::uint64_t>(*count)) : get(term);
  }

  const Master& master_;
  const Values& values_;
  std::uint32_t polynomial_;
};

// The singleturn and multiturn bits are settings of their own.
bool has_parts(const Master& master) {
  return master.find("singleturn") != nullptr || master.find("counts_singleturn") != nullptr;
}

std::string crc_text(const CrcSpec& crc) {
  return crc.present() ? fmt::format("crc{}:0x{:X}", crc.width_bits, crc.polynomial) : "no CRC";
}

std::string has_only(const Master& master, std::string_view what, bool assumed = false) {
  return assumed               ? fmt::format("{} is assumed for this master: no source", what)
         : master.open("more") ? fmt::format("not in this table, which has only {}", what)
                               : fmt::format("the master has only {}", what);
}

std::string_view no_parameter(const Master& master) {
  return master.open("more") ? "not in this table" : "no parameter for it is known";
}

// Why the master cannot read the format: the first thing that it reads otherwise. Empty if it can.
std::string misread(const Master& master, const FrameFormat& format, const FrameFormat& read) {
  const BitLayout sent(format.channel_list[0]);
  const BitLayout seen(read.channel_list[0]);
  const CrcSpec& crc = sent.channel.crc;
  const CrcSpec& crc_seen = seen.channel.crc;
  const bool assumed = master.assumes("crc");
  const bool any = master.any_polynomial();
  if (crc.present() ? !any && crc.polynomial != crc_seen.polynomial : crc_seen.present()) {
    return fmt::format("crc_polynomial: {}; {}", crc_text(crc),
                       has_only(master, any ? "frames with one" : crc_text(crc_seen), assumed));
  }
  if (!any && crc.inverted != crc_seen.inverted && crc.present()) {
    return "crc_plain: the CRC is not inverted; " + (assumed
                                                         ? has_only(master, "an inverted one", true)
                                                         : "the master has no setting for it");
  }
  if (!master.open("crc") && crc.start != crc_seen.start) {
    return fmt::format("crc_start: the start value is 0x{:X}; {}", crc.start,
                       has_only(master, "0", assumed));
  }
  if (sent.channel.coded() && !seen.channel.coded()) {
    return fmt::format("coding: Gray code; {}", no_parameter(master));
  }
  if (sent.channel.coded() && sent.multiturn > 0) {
    return "coding: Gray code of multiturn and singleturn bits; the setting is for one number";
  }
  if (master.open("arrangement")) return {};
  if (sent.lead != seen.lead || sent.gap != seen.gap || sent.tail() != seen.tail()) {
    return fmt::format("padding: {}, {} and {} bits before, within and after the position; {}",
                       sent.lead, sent.gap, sent.tail(), no_parameter(master));
  }
  const std::size_t needed = master.open("more") ? 2 : master.status_needed();
  if (sent.status.size() != seen.status.size() ||
      sent.status.substr(0, needed) != seen.status.substr(0, needed)) {
    const char* const what = needed == 0                             ? "two bits"
                             : needed == 1                           ? "nE and one more bit"
                             : master.find("status_high") != nullptr ? "nE,nW or E,W"
                                                                     : "nE,nW";
    return "status: before the CRC, " + has_only(master, what, master.assumes("status"));
  }
  return {};
}

// ---- From a format to values

std::uint64_t hertz_of(const Parameter& row, std::uint64_t value) {
  for (const auto& [code, hertz] : row.codes) {
    if (code == value) return hertz;
  }
  if (row.base != 0) return row.base / (value + 1);
  if (row.unit != 0) return row.unit * value;
  return value == 0 || !row.codes.empty() ? 0 : 1'000'000'000'000 / value;
}

// The value for a clock, within 0.2 percent.
tl::expected<std::uint64_t, std::string> clock_value(const Parameter& row, Hertz clock) {
  std::vector<std::uint64_t> values;
  for (const auto& each : row.codes) values.push_back(each.first);
  if (row.base != 0) {
    for (std::uint64_t value = row.low; value <= row.high; ++value) values.push_back(value);
  } else if (row.codes.empty()) {
    const std::uint64_t value =
        row.unit != 0 ? clock.count / row.unit : 1'000'000'000'000 / clock.count;
    values.push_back(std::clamp(value, row.low, row.high));
  }
  std::uint64_t lower = 0;
  for (const std::uint64_t value : values) {
    const std::uint64_t hertz = hertz_of(row, value);
    const std::uint64_t off = hertz > clock.count ? hertz - clock.count : clock.count - hertz;
    if (off * 500 <= clock.count) return value;
    if (hertz < clock.count) lower = std::max(lower, hertz);
  }
  return tl::unexpected(fmt::format(
      "clock: {} has no {}; {}", row.key, text_of(clock),
      lower == 0 ? std::string("all its clocks are higher")
                 : "the next lower one is " + text_of(hertz(static_cast<std::uint32_t>(lower)))));
}

std::string range_text(const Parameter& row) {
  return row.low == row.high ? fmt::format("only {}", row.low)
                             : fmt::format("{} to {}", row.low, row.high);
}

// Why a number of a format is outside the limits of the row.
std::string limit_text(const Master& master, const Parameter& row, std::uint64_t value) {
  const bool no_crc = value == 0 && row.term.starts_with("crc_");
  if (no_crc || row.term.starts_with("polynomial") || row.term == "crc_usual") {
    return fmt::format("crc_polynomial: {}{}", value == 0 ? "no CRC; " : "",
                       has_only(master, value == 0        ? "frames with one"
                                        : row.key.empty() ? row.name
                                                          : range_text(row)));
  }
  const auto cause = row.term.starts_with("after_") ? "status" : row.term;
  return fmt::format("{}: {} is {}; {} {}", cause.substr(0, cause.find("_minus")),
                     row.key.empty() ? row.name : row.key, value,
                     master.open("more") ? "not in this table, which has" : "the master has",
                     range_text(row));
}

tl::expected<Values, std::string> values_of(const Master& master, const FrameFormat& format,
                                            const LineTimes& times) {
  if (format.channel_count > 1) {
    return tl::unexpected(fmt::format(
        "chain: the frame has {} channels; the table has settings for one", format.channel_count));
  }
  const BitLayout frame(format.channel_list[0]);
  const ChannelFormat& channel = frame.channel;
  if (channel.crc.deviates()) {
    return tl::unexpected(std::string("crc_error: no master has a setting for this error"));
  }
  if (channel.position_lsb || channel.multiturn_lsb || channel.singleturn_lsb) {
    return tl::unexpected(std::string("coding: no master reads the lowest bit first"));
  }
  if (!frame.in_order && !master.open("arrangement")) {
    return tl::unexpected(std::string(
        "arrangement: the master needs multiturn, singleturn, status bits and CRC in this order"));
  }
  const auto steps = [](const Parameter& row, Picoseconds time) {
    const auto step = std::uint64_t{1'000'000'000'000} / row.steps;
    return std::max(row.fallback.value_or(0),
                    (static_cast<std::uint64_t>(time.count) + step - 1) / step);
  };
  Values values;
  for (const Parameter& row : master.parameters) {
    const Term* const term = find_term(row.term);
    Number value = term == nullptr ? std::nullopt : term->value(frame);
    if (row.term == "clock" && times.clock) {
      const auto found = clock_value(row, *times.clock);
      if (!found) return tl::unexpected(found.error());
      value = *found;
    } else if (row.term == "busy" && times.ack_max) {
      value = steps(row, *times.ack_max);
    } else if (row.term == "timeout" && times.timeout) {
      value = steps(row, *times.timeout);
    }
    values.push_back(value ? value : row.fallback);
    if (values.back() && (*values.back() < row.low || *values.back() > row.high)) {
      return tl::unexpected(limit_text(master, row, *values.back()));
    }
  }
  const auto read = FormatMaker(master, values, channel.crc.polynomial).make();
  if (!read && !channel.crc.present()) {
    return tl::unexpected("crc_polynomial: no CRC; " +
                          has_only(master, "crc6:0x43", master.assumes("crc")));
  }
  std::string why = misread(master, format, read ? *read : FrameFormat());
  if (!why.empty()) return tl::unexpected(std::move(why));
  return values;
}

// ---- Values as text

std::string text_of_value(const Parameter& row, std::uint64_t value) {
  if (!row.names.empty()) return std::string(row.names[static_cast<std::size_t>(value - row.low)]);
  switch (row.form) {
    case Form::hexadecimal:
      return fmt::format("0x{:X}", value);
    case Form::word:
      return fmt::format("0x{:08X}", value);
    case Form::dollar:
      return fmt::format("${:06X}", value);
    case Form::microseconds:
      return fmt::format("{:g}", static_cast<double>(value) / 1e6);
    case Form::decimal:
      break;
  }
  return fmt::format("{}", value);
}

Number value_in(const Parameter& row, std::string text) {
  const auto name = std::find(row.names.begin(), row.names.end(), text);
  if (name != row.names.end()) {
    return row.low + static_cast<std::uint64_t>(name - row.names.begin());
  }
  if (!row.names.empty()) return std::nullopt;
  if (row.form == Form::microseconds) {
    const auto time = parse_duration(text + "us");
    return time.ok() ? Number(time->count) : std::nullopt;
  }
  if (row.high == 1 && (same_text(text, "true") || same_text(text, "false"))) {
    return text.size() == 4 ? 1 : 0;
  }
  if (text.starts_with('$')) text.replace(0, 1, "0x");
  const auto count = parse_count(text);
  return count.ok() ? Number(*count) : std::nullopt;
}

std::string allowed_values(const Parameter& row) {
  std::vector<std::uint64_t> codes;
  for (const auto& each : row.codes) codes.push_back(each.first);
  if (!codes.empty()) return fmt::format("{}", fmt::join(codes, ", "));
  if (!row.names.empty()) return fmt::format("{}", fmt::join(row.names, ", "));
  if (row.term.starts_with("counts_")) return "a power of 2";
  if (row.form == Form::microseconds) {
    return fmt::format("{} to {} us", text_of_value(row, row.low), text_of_value(row, row.high));
  }
  return (row.low == row.high ? "" : "a number from ") + range_text(row);
}

bool is_allowed(const Parameter& row, std::uint64_t value) {
  if (row.term.starts_with("counts_") && !std::has_single_bit(value)) return false;
  const bool is_code =
      row.codes.empty() || std::any_of(row.codes.begin(), row.codes.end(),
                                       [value](const auto& each) { return each.first == value; });
  return value >= row.low && value <= row.high && is_code;
}

// ---- Settings as a user types them

/// Reads `KEY=VALUE` texts; throws a VerbError if they are wrong.
class SettingsReader {
 public:
  explicit SettingsReader(const Master& master)
      : rows_(master.parameters), master_(master), values_(rows_.size()) {}

  void read(const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos)
      fail("no_value", fmt::format("'{}': write KEY=VALUE", setting));
    std::string key = setting.substr(0, equals);
    for (const std::string_view channel : master_.channels) {
      if (!same_text(std::string_view(key).substr(0, channel.size()), channel)) continue;
      key.replace(0, channel.size(), master_.channels.front());
    }
    const auto row = std::find_if(rows_.begin(), rows_.end(),
                                  [&](const Parameter& each) { return is_key(each.key, key); });
    if (row == rows_.end()) {
      std::vector<std::string> keys;
      for (const Parameter& each : rows_) {
        if (!each.key.empty() && (keys.empty() || keys.back() != each.key)) {
          keys.emplace_back(each.key);
        }
      }
      const std::string near = nearest(key, keys);
      fail("unknown_key",
           fmt::format("'{}'{}; the keys are {}", key,
                       near.empty() ? "" : ": did you mean " + near + "?", fmt::join(keys, ", ")));
    }
    if (row->term == "unknown") fail("unknown_value", fmt::format("{}: {}", row->key, row->doubt));
    const auto first = static_cast<std::size_t>(row - rows_.begin());
    if (values_[first]) fail("key_twice", std::string(row->key));
    read_value(first, setting.substr(equals + 1));
  }

  /// The values that were given.
  Values given() const { return values_; }

  /// The values of all rows; `assumed` gets the parameters that were left out.
  Values finish(std::vector<std::string>& assumed) {
    std::vector<std::string_view> missing;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Parameter& row = rows_[i];
      if (values_[i] || row.key.empty() || row.term == "clock") continue;
      values_[i] = row.fallback;
      if (row.fallback && (row.bits == 0 || is_format(row))) {
        assumed.push_back(fmt::format("{}={}", row.key, text_of_value(row, *row.fallback)));
      }
      if (row.fallback || !is_format(row)) continue;
      if (missing.empty() || missing.back() != row.key) missing.push_back(row.key);
    }
    if (!missing.empty()) fail("missing_key", fmt::format("give {}", fmt::join(missing, ", ")));
    return values_;
  }

 private:
  [[noreturn]] void fail(std::string_view cause, const std::string& why) const {
    throw wrong_usage("{}: {}: {}", master_.name, cause, why);
  }

  // The whole key, or its last part with its colon or point.
  static bool is_key(std::string_view key, std::string_view given) {
    const bool part = given.starts_with(':') || given.starts_with('.');
    if (part && key.size() > given.size()) key.remove_prefix(key.size() - given.size());
    return !given.empty() && same_text(key, given);
  }

  // All rows with the key of row `first`.
  void read_value(std::size_t first, const std::string& text) {
    const bool is_word = rows_[first].bits != 0;
    const bool alone = first + 1 == rows_.size() || rows_[first + 1].key != rows_[first].key;
    const Number word = is_word ? value_in(rows_[first], text) : std::nullopt;
    std::string_view rest = text;
    std::uint64_t unknown = word.value_or(0);
    const auto wrong = [&](const std::string& why) {
      fail("wrong_value", fmt::format("{}={}: {}", rows_[first].key, text, why));
    };
    // Digits that are another number on a screen with hexadecimal numbers.
    if (const Form form = rows_[first].form;
        form != Form::decimal && form != Form::microseconds && text.size() > 1 &&
        text.find_first_not_of("0123456789") == std::string::npos && parse_count(text).ok()) {
      wrong(
          fmt::format("write 0x{} or, if it is decimal, 0x{:X}", text, parse_count(text).value()));
    }
    for (std::size_t i = first; i < rows_.size() && rows_[i].key == rows_[first].key; ++i) {
      const Parameter& row = rows_[i];
      Number value;
      if (is_word) {
        if (word && *word <= UINT32_MAX) value = (*word >> row.shift) & low_mask(row.bits);
        unknown &= ~(low_mask(row.bits) << row.shift);
      } else if (rest.starts_with(row.before)) {
        rest.remove_prefix(row.before.size());
        if (row.may_be_negative && rest.starts_with('-')) rest.remove_prefix(1);
        const std::size_t digits = rest.find_first_not_of("0123456789");
        const auto part = rest.substr(0, alone || !row.names.empty() ? rest.size() : digits);
        value = value_in(row, std::string(part));
        rest.remove_prefix(part.size());
      }
      if (!value || !is_allowed(row, *value)) {
        wrong(fmt::format("{}: {}", row.name, allowed_values(row)));
      }
      values_[i] = value;
    }
    if (!is_word && !rest.empty()) wrong(fmt::format("'{}' is too much", rest));
    if (unknown != 0) {
      wrong(fmt::format("the bits 0x{:X} have no meaning in this table", unknown));
    }
  }

  const std::vector<Parameter>& rows_;
  const Master& master_;
  Values values_;
};

// Why the value is not certain; empty if it is.
std::string_view doubt_of(const Parameter& row, const Number& value) {
  return value && value == row.sure ? "" : row.doubt;
}

// Why these are not the settings of the format; empty if they are.
std::string contradiction(const Master& master, const FrameFormat& format, const Values& values,
                          const Values& given) {
  const auto needed = values_of(master, format, {});
  if (!needed) return needed.error();
  // A polynomial has two forms.
  const bool same_crc =
      FormatMaker(master, values).crc_polynomial() == format.channel_list[0].crc.polynomial;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& row = master.parameters[i];
    if (!is_format(row) || row.key.empty() || values[i] == (*needed)[i]) continue;
    if (row.term == "status_off" && values[i] == 1) continue;
    if (same_crc && (row.term == "crc_usual" || row.term == "crc_field")) continue;
    // Nor is it certain which form of a polynomial this is.
    if (row.sure && row.term == "polynomial" && values[i] == *(*needed)[i] >> 1U) continue;
    const std::string_view doubt = doubt_of(row, values[i]);
    return fmt::format(
        "{} ({}) is {}{} and must be {}{}{}", row.key, row.name, text_of_value(row, *values[i]),
        given[i] ? "" : ", the default, as it was left out,", text_of_value(row, *(*needed)[i]),
        doubt.empty() ? "" : "; not certain: ", doubt);
  }
  return {};
}

std::vector<std::string> open_facts(const Master& master, const ChannelFormat& channel) {
  std::vector<std::string> open;
  if (master.open("arrangement")) {
    open.push_back(
        fmt::format("arrangement: {} bits before the CRC in any order", channel.data_bits));
  } else if (!has_parts(master) && !channel.multiturn.present()) {
    open.push_back(
        fmt::format("turns: pos{0}, or mtA,stB with A + B = {0}", channel.position_bits()));
  }
  if (master.assumes("status")) {
    open.emplace_back("status: nE,nW is assumed: no source");
  } else if (master.status_needed() < 2) {
    open.emplace_back("status: nE,nW, or other bits, such as nE,pad1 or E,W");
  }
  if (master.assumes("crc")) {
    open.emplace_back("crc: 0x43, start 0, inverted is assumed: no source");
  } else if (master.any_polynomial()) {
    open.push_back(fmt::format("crc: {} are not in the settings",
                               master.open("crc") ? "polynomial, start value and inversion"
                                                  : "polynomial and start value"));
  }
  if (const CrcSpec& crc = channel.crc; crc.polynomial != default_polynomial(crc.width_bits)) {
    open.push_back(
        fmt::format("polynomial: {} is not usual: was a form with or without its last bit meant?",
                    crc_text(crc)));
  }
  open.emplace_back("cds: add ;cds0 if the encoder is unidirectional");
  return open;
}

}  // namespace

tl::expected<std::vector<Setting>, std::string> settings_for(const Master& master,
                                                             const FrameFormat& format,
                                                             const LineTimes& times) {
  const auto values = values_of(master, format, times);
  if (!values) return tl::unexpected(values.error());
  std::vector<Setting> settings;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < values->size(); ++i) {
    const Parameter& row = master.parameters[i];
    const Number& value = (*values)[i];
    if (row.key.empty()) continue;
    if (settings.empty() || settings.back().rows.front()->key != row.key) {
      settings.emplace_back();
      word = 0;
    }
    Setting& setting = settings.back();
    setting.rows.push_back(&row);
    if (!doubt_of(row, value).empty()) setting.doubts.push_back(row.doubt);
    setting.complete = setting.complete && (value || row.term == "unknown");
    if (!value) {
      setting.value = "?";
    } else if (row.bits != 0) {
      word |= *value << row.shift;
      setting.value = text_of_value(*setting.rows.front(), word);
    } else {
      setting.value += fmt::format("{}{}", row.before, text_of_value(row, *value));
    }
  }
  std::erase_if(settings, [](const Setting& each) { return !each.complete; });
  return settings;
}

Found format_of(const Master& master, const std::vector<std::string>& settings,
                const std::optional<FrameFormat>& expected) {
  Found found;
  SettingsReader reader(master);
  for (const std::string& setting : settings) reader.read(setting);
  const Values given = reader.given();
  const Values values = reader.finish(found.assumed);
  if (expected) {
    found.format = *expected;
    for (const std::string& fact : open_facts(master, expected->channel_list[0])) {
      found.not_compared.push_back(fact.substr(0, fact.find(':')) + ": as in -f");
    }
  } else {
    const auto format = FormatMaker(master, values).make();
    if (!format) throw wrong_usage("{}: not_a_format: {}", master.name, format.error());
    found.format = *format;
    found.open = open_facts(master, found.format.channel_list[0]);
  }
  if (const auto why = contradiction(master, found.format, values, given); !why.empty()) {
    throw wrong_usage("{}: contradiction: for {}: {}", master.name,
                      format_text(found.format).view(), why);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& row = master.parameters[i];
    if (!doubt_of(row, values[i]).empty() && (given[i] || is_format(row)) && !row.key.empty()) {
      found.doubts.push_back(fmt::format("{}: {}", row.key, row.doubt));
    }
    if (expected && row.key.empty() && row.uncertain()) found.not_compared.emplace_back(row.name);
    if (!given[i]) continue;
    if (row.term == "clock") {
      found.times.clock = hertz(static_cast<std::uint32_t>(hertz_of(row, *values[i])));
    } else if (row.term == "busy" || row.term == "timeout") {
      (row.term == "busy" ? found.times.ack_max : found.times.timeout) =
          static_cast<std::int64_t>(*values[i]) * (milliseconds(1'000) / std::int64_t{row.steps});
    } else if (expected && row.low != row.high &&
               (!is_format(row) ||
                (row.sure && row.term == "polynomial" && values[i] != row.sure))) {
      found.not_compared.push_back(fmt::format("{}: {}", row.key, row.name));
    }
  }
  return found;
}

}  // namespace biss::verbs
