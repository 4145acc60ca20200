#include "verbs/settings/exchange.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "device/nearest.hpp"
#include "device/quantity.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {
namespace {

using Number = std::optional<std::int64_t>;
/// The value of each row of a master.
using Values = std::vector<Number>;

// ---- The terms of masters.txt

/// The bits of a channel in the order lead, multiturn, gap, singleturn, bits after the position.
struct BitLayout {
  explicit BitLayout(const ChannelFormat& of) : channel(of) {
    for (const auto& [flag, letters] : {std::pair(of.error, "eE"), std::pair(of.warning, "wW")}) {
      if (!flag.present) continue;
      const std::size_t from_end = flag.shift + std::size_t{1};
      in_order = in_order && from_end <= status.size();
      if (in_order) status[status.size() - from_end] = letters[flag.active_high ? 1 : 0];
    }
  }

  ChannelFormat channel;
  biss::Field low = channel.position.present() ? channel.position : channel.singleturn;
  biss::Field high = channel.multiturn.present() ? channel.multiturn : low;
  int multiturn = channel.multiturn.bits;
  int singleturn = low.bits;
  int after = low.shift;
  int tail = std::max(after - 2, 0);
  int lead = channel.data_bits - high.shift - high.bits;
  int gap = multiturn == 0 ? 0 : high.shift - low.shift - low.bits;
  /// A letter for each of the last two bits before the CRC: e, w, E, W as in a format, p padding.
  std::string status = std::string(static_cast<std::size_t>(after - tail), 'p');
  bool in_order = low.present() && gap >= 0 && !channel.life_counter.present();
};

/// The value of each term for a frame; nothing: the row keeps its fallback.
std::map<std::string_view, Number> terms_of(const BitLayout& frame) {
  const ChannelFormat& channel = frame.channel;
  const CrcSpec& crc = channel.crc;
  const bool usual = crc.polynomial == default_polynomial(crc.width_bits);
  const int position = frame.multiturn + frame.singleturn;
  return {
      {"multiturn", frame.multiturn},
      {"singleturn", frame.singleturn},
      {"position", position},
      {"lead", frame.lead},
      {"tail", frame.tail},
      {"payload", channel.data_bits - frame.after + frame.tail},
      {"first_multiturn", frame.multiturn == 0 ? Number() : frame.lead},
      {"first_singleturn", frame.lead + frame.multiturn + frame.gap},
      {"after_bits", frame.after},
      {"after_all", frame.after + crc.width_bits},
      {"data", channel.data_bits},
      {"data_minus_1", channel.data_bits - 1},
      {"frame", channel.total_bits()},
      {"status_off", frame.status == "ew" ? 0 : 1},
      {"status_high", frame.status == "EW" ? 1 : 0},
      {"gray", channel.coded() ? 1 : 0},
      {"polynomial", crc.polynomial},
      {"polynomial_half", crc.polynomial >> 1U},
      {"crc_width", crc.width_bits},
      {"crc_usual", usual ? 0 : 1},
      {"crc_field", usual ? Number(crc.width_bits) : crc.polynomial >> 1U},
      {"crc_inverted", crc.present() ? Number(crc.inverted ? 1 : 0) : std::nullopt},
      {"crc_start", crc.start},
      // Users may choose other values than these.
      {"counts_free", position},
      {"turns_free", frame.multiturn > 0 ? 1 : 0},
  };
}

// The row has a fact of the format.
bool is_format(const Parameter& row) {
  static const auto terms = terms_of(BitLayout(ChannelFormat()));
  return terms.contains(row.term) && !row.term.ends_with("_free");
}

// ---- From values to a format

/// The format that values describe; what they leave open is as in most encoders.
struct FormatMaker {
  const Master& master;
  const Values& values;
  /// The polynomial of a CRC whose width has no usual one.
  std::int64_t polynomial = 0;

  tl::expected<FrameFormat, std::string> make() const {
    const std::string text = text_of_format();
    if (text.empty()) {
      return tl::unexpected<std::string>(
          "the numbers of bits do not fit together, or are not in this table");
    }
    const auto format = parse_format(text);
    if (format.ok()) return *format;
    return tl::unexpected(fmt::format("{}: {}", text, text_of(format.error().mistake)));
  }

  std::int64_t crc_polynomial() const {
    if (const auto full = get("polynomial")) return *full;
    const auto half = get("crc_usual") == 1 ? get("crc_field") : get("polynomial_half");
    if (half) return *half == 0 ? 0 : *half << 1 | 1;
    const auto width = get("crc_field") ? get("crc_field") : get("crc_width");
    if (!width) return 0x43;
    const std::uint32_t usual = default_polynomial(static_cast<unsigned>(*width));
    return usual != 0 ? usual : polynomial;
  }

 private:
  std::string text_of_format() const {
    const std::int64_t crc = crc_polynomial();
    const std::int64_t width = std::bit_width(static_cast<std::uint32_t>(crc) >> 1U);
    const Number turns_given = get("multiturn");
    Number singleturn = get("singleturn");
    std::int64_t turns = turns_given.value_or(0);
    std::int64_t lead = get("lead").value_or(0);
    std::int64_t gap = 0;
    std::int64_t after = get("after_bits").value_or(2 + get("tail").value_or(0));
    if (const auto all = get("after_all")) after = *all - width;
    if (const auto first = get("first_singleturn")) {
      lead = turns > 0 ? get("first_multiturn").value_or(0) : *first;
      gap = *first - lead - turns;
      after = get("payload").value_or(0) - *first - singleturn.value_or(0) + 2;
    }
    Number position = get("position");
    if (const auto payload = get("payload")) position = *payload - lead - (after - 2);
    if (const auto data = get("data")) position = *data - after - lead;
    if (const auto data = get("data_minus_1")) position = *data + 1 - after;
    if (const auto frame = get("frame"); frame && !position) position = *frame - width - after;
    if (position && singleturn && !turns_given) turns = *position - *singleturn;
    if (!singleturn) singleturn = position.value_or(0) - turns;
    if (*singleturn < 1 || turns < 0 || lead < 0 || gap < 0 || after < 0) return {};
    std::string text;
    const auto add = [&text](std::string_view name, std::int64_t count,
                             std::string_view suffix = "") {
      if (count > 0) text += fmt::format("{}{}{},", name, count, suffix);
    };
    const std::string_view gray = get("gray") == 1 ? ":gray" : "";
    add("pad", lead);
    add("mt", turns, gray);
    add("pad", gap);
    add(turns > 0 ? "st" : "pos", *singleturn, gray);
    add("pad", after - 2);
    const bool high = get("status_high") == 1;
    if (after >= 1) text += high ? "E," : "nE,";
    if (after >= 2) text += high ? "W," : "nW,";
    if (crc == 0) {
      add("crc", get("crc_width").value_or(0));  // an error, unless it is 0
    } else {
      text += fmt::format("crc{}:0x{:X}:0x{:X}{},", width, crc, get("crc_start").value_or(0),
                          get("crc_inverted").value_or(1) == 1 ? "" : ":plain");
    }
    text.pop_back();
    return text;
  }

  Number get(std::string_view term) const {
    const Parameter* const row = master.find(term);
    if (row == nullptr) return std::nullopt;
    return values[static_cast<std::size_t>(row - master.parameters.data())];
  }
};

std::string crc_text(const CrcSpec& crc) {
  return crc.present() ? fmt::format("crc{}:0x{:X}", crc.width_bits, crc.polynomial) : "no CRC";
}

std::string has_only(const Master& master, std::string_view fact, std::string_view what) {
  return master.assumes(fact)  ? fmt::format("{} is assumed for this master: no source", what)
         : master.open("more") ? fmt::format("not in this table, which has only {}", what)
                               : fmt::format("the master has only {}", what);
}

// Why the master cannot read the format: the first thing that it reads otherwise. Empty if it can.
std::string misread(const Master& master, const FrameFormat& format, const FrameFormat& read) {
  const BitLayout sent(format.channel_list[0]);
  const BitLayout seen(read.channel_list[0]);
  const CrcSpec& crc = sent.channel.crc;
  const CrcSpec& crc_seen = seen.channel.crc;
  const bool any = master.any_polynomial();
  if (crc.present() ? !any && crc.polynomial != crc_seen.polynomial : crc_seen.present()) {
    return fmt::format("crc_polynomial: {}; {}", crc_text(crc),
                       has_only(master, "crc", any ? "frames with one" : crc_text(crc_seen)));
  }
  if (!any && crc.inverted != crc_seen.inverted && crc.present()) {
    return "crc_plain: the CRC is not inverted; " + has_only(master, "crc", "an inverted one");
  }
  if (!master.open("crc") && crc.start != crc_seen.start) {
    return fmt::format("crc_start: the start value is 0x{:X}; {}", crc.start,
                       has_only(master, "crc", "0"));
  }
  const std::string_view no_parameter =
      master.open("more") ? "not in this table" : "no parameter for it is known";
  if (sent.channel.coded() && !seen.channel.coded()) {
    return fmt::format("coding: Gray code; {}", no_parameter);
  }
  if (sent.channel.coded() && sent.multiturn > 0) {
    return "coding: Gray code of multiturn and singleturn bits; the setting is for one number";
  }
  if (master.open("arrangement")) return {};
  if (sent.lead != seen.lead || sent.gap != seen.gap || sent.tail != seen.tail) {
    return fmt::format("padding: {}, {} and {} bits before, within and after the position; {}",
                       sent.lead, sent.gap, sent.tail, no_parameter);
  }
  const std::size_t needed = master.open("more") ? 2 : master.status_needed();
  if (sent.status.size() != seen.status.size() ||
      sent.status.substr(0, needed) != seen.status.substr(0, needed)) {
    const char* const what = needed == 0                             ? "two bits"
                             : needed == 1                           ? "nE and one more bit"
                             : master.find("status_high") != nullptr ? "nE,nW or E,W"
                                                                     : "nE,nW";
    return "status: before the CRC, " + has_only(master, "status", what);
  }
  return {};
}

// ---- From a format to values

std::int64_t hertz_of(const Parameter& row, std::int64_t value) {
  if (!row.codes.empty()) return row.codes.contains(value) ? row.codes.at(value) : 0;
  if (row.base != 0) return row.base / (value + 1);
  if (row.unit != 0) return row.unit * value;
  return value == 0 ? 0 : picoseconds_per_second / value;
}

// The value for a clock, within 0.2 percent.
tl::expected<std::int64_t, std::string> clock_value(const Parameter& row, Hertz clock) {
  std::vector<std::int64_t> values;
  for (const auto& [code, rate] : row.codes) values.push_back(code);
  for (auto value = row.low; row.base != 0 && value <= row.high; ++value) values.push_back(value);
  if (values.empty()) {
    const auto value =
        row.unit != 0 ? clock.count / row.unit : picoseconds_per_second / clock.count;
    values.push_back(std::clamp(value, row.low, row.high));
  }
  std::int64_t lower = 0;
  for (const std::int64_t value : values) {
    const std::int64_t rate = hertz_of(row, value);
    if (std::abs(rate - clock.count) * 500 <= clock.count) return value;
    if (rate < clock.count) lower = std::max(lower, rate);
  }
  return tl::unexpected(fmt::format(
      "clock: {} has no {}; {}", row.key, text_of(clock),
      lower == 0 ? "all its clocks are higher"
                 : "the next lower one is " + text_of(hertz(static_cast<std::uint32_t>(lower)))));
}

std::string range_text(const Parameter& row) {
  return row.low == row.high ? fmt::format("only {}", row.low)
                             : fmt::format("{} to {}", row.low, row.high);
}

// Why a number of a format is outside the limits of the row.
std::string limit_text(const Master& master, const Parameter& row, std::int64_t value) {
  const bool no_crc = value == 0 && row.term.starts_with("crc_");
  if (no_crc || row.term.starts_with("polynomial") || row.term == "crc_usual") {
    const std::string limit = row.key.empty() ? std::string(row.name) : range_text(row);
    return fmt::format("crc_polynomial: {}{}", value == 0 ? "no CRC; " : "",
                       has_only(master, "crc", value == 0 ? "frames with one" : limit));
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
  const std::string_view why =
      channel.crc.deviates() ? "crc_error: no master has a setting for this error"
      : channel.position_lsb || channel.multiturn_lsb || channel.singleturn_lsb
          ? "coding: no master reads the lowest bit first"
      : frame.in_order || master.open("arrangement")
          ? ""
          : "arrangement: the master needs multiturn, singleturn, status bits and CRC in this "
            "order";
  if (!why.empty()) return tl::unexpected(std::string(why));
  const auto terms = terms_of(frame);
  Values values;
  for (const Parameter& row : master.parameters) {
    const auto term = terms.find(row.term);
    Number value = term == terms.end() ? row.fallback : term->second;
    if (row.term == "clock" && times.clock) {
      const auto found = clock_value(row, *times.clock);
      if (!found) return tl::unexpected(found.error());
      value = *found;
    }
    if (const auto& time = row.term == "busy" ? times.ack_max : times.timeout;
        time && (row.term == "busy" || row.term == "timeout")) {
      const std::int64_t step = picoseconds_per_second / row.steps;
      value = std::max(row.fallback.value_or(0), (time->count + step - 1) / step);
    }
    values.push_back(value ? value : row.fallback);
    if (values.back() && (*values.back() < row.low || *values.back() > row.high)) {
      return tl::unexpected(limit_text(master, row, *values.back()));
    }
  }
  const auto read = FormatMaker{master, values, channel.crc.polynomial}.make();
  // Values that do not fit together without a CRC: the master needs one.
  const FrameFormat none =
      channel.crc.present() ? FrameFormat() : parse_format("pos1,nE,nW,crc6").value();
  std::string other = misread(master, format, read ? *read : none);
  if (!other.empty()) return tl::unexpected(std::move(other));
  return values;
}

// ---- Values as text

std::string text_of_value(const Parameter& row, std::int64_t value) {
  if (!row.names.empty()) return std::string(row.names[static_cast<std::size_t>(value - row.low)]);
  if (row.form == Form::microseconds) return fmt::format("{:g}", static_cast<double>(value) / 1e6);
  constexpr const char* forms[] = {"{}", "", "{}", "0x{:X}", "0x{:08X}", "${:06X}"};
  return fmt::format(fmt::runtime(forms[static_cast<std::size_t>(row.form)]),
                     row.form == Form::power ? std::int64_t{1} << value : value);
}

Number value_in(const Parameter& row, std::string text) {
  if (!row.names.empty()) {
    const auto name = std::find(row.names.begin(), row.names.end(), text);
    return name == row.names.end() ? Number() : row.low + (name - row.names.begin());
  }
  if (row.form == Form::microseconds) {
    const auto time = parse_duration(text + "us");
    return time.ok() ? Number(time->count) : std::nullopt;
  }
  if (row.high == 1 && same_text(text, "true")) return 1;
  if (row.high == 1 && same_text(text, "false")) return 0;
  if (text.starts_with('$')) text.replace(0, 1, "0x");
  const auto count = parse_count(text, INT64_MAX);
  if (!count.ok()) return std::nullopt;
  if (row.form != Form::power) return static_cast<std::int64_t>(*count);
  return std::has_single_bit(*count) ? Number(std::countr_zero(*count)) : std::nullopt;
}

std::string allowed_values(const Parameter& row) {
  std::vector<std::int64_t> codes;
  for (const auto& [code, rate] : row.codes) codes.push_back(code);
  if (!codes.empty()) return fmt::format("{}", fmt::join(codes, ", "));
  if (!row.names.empty()) return fmt::format("{}", fmt::join(row.names, ", "));
  if (row.form == Form::power) return "a power of 2";
  if (row.form == Form::microseconds) {
    return fmt::format("{} to {} us", text_of_value(row, row.low), text_of_value(row, row.high));
  }
  return (row.low == row.high ? "" : "a number from ") + range_text(row);
}

// ---- Settings as a user types them

/// Reads `KEY=VALUE` texts; throws a VerbError if they are wrong.
struct SettingsReader {
  const Master& master;
  /// Those that were given.
  Values values = Values(master.parameters.size());

  void read(const std::string& setting) {
    const auto& rows = master.parameters;
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) fail("no_value: '{}': write KEY=VALUE", setting);
    std::string key = setting.substr(0, equals);
    for (const std::string_view channel : master.channels) {
      if (!same_text(std::string_view(key).substr(0, channel.size()), channel)) continue;
      key.replace(0, channel.size(), master.channels.front());
    }
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const Parameter& each) { return is_key(each.key, key); });
    if (row == rows.end()) {
      const std::vector<std::string> keys = master.keys();
      const std::string near = nearest(key, keys);
      fail("unknown_key: '{}'{}; the keys are {}", key,
           near.empty() ? "" : ": did you mean " + near + "?", fmt::join(keys, ", "));
    }
    if (row->term == "unknown") fail("unknown_value: {}: {}", row->key, row->doubt);
    const auto first = static_cast<std::size_t>(row - rows.begin());
    if (values[first]) fail("key_twice: {}", row->key);
    read_value(first, setting.substr(equals + 1));
  }

  /// The values of all rows; `assumed` gets the parameters that were left out.
  Values finish(std::vector<std::string>& assumed) const {
    Values all = values;
    std::vector<std::string_view> missing;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Parameter& row = master.parameters[i];
      if (all[i] || row.key.empty() || row.term == "clock") continue;
      all[i] = row.fallback;
      if (row.fallback && (row.bits == 0 || is_format(row))) {
        assumed.push_back(fmt::format("{}={}", row.key, text_of_value(row, *row.fallback)));
      }
      if (row.fallback || !is_format(row)) continue;
      if (missing.empty() || missing.back() != row.key) missing.push_back(row.key);
    }
    if (!missing.empty()) fail("missing_key: give {}", fmt::join(missing, ", "));
    return all;
  }

 private:
  template <class... Arguments>
  [[noreturn]] void fail(fmt::format_string<Arguments...> why, Arguments&&... arguments) const {
    throw wrong_usage("{}: {}", master.name,
                      fmt::format(why, std::forward<Arguments>(arguments)...));
  }

  // The whole key, or its last part with its colon or point.
  static bool is_key(std::string_view key, std::string_view given) {
    const bool part = given.starts_with(':') || given.starts_with('.');
    if (part && key.size() > given.size()) key.remove_prefix(key.size() - given.size());
    return !given.empty() && same_text(key, given);
  }

  // All rows with the key of row `first`.
  void read_value(std::size_t first, const std::string& text) {
    const auto& rows = master.parameters;
    const Parameter& key = rows[first];
    const bool is_word = key.bits != 0;
    const bool alone = first + 1 == rows.size() || rows[first + 1].key != key.key;
    const auto wrong = [&](const std::string& why) {
      fail("wrong_value: {}={}: {}", key.key, text, why);
    };
    // Digits that are another number on a screen with hexadecimal numbers.
    if (const auto decimal = parse_count(text);
        key.form >= Form::hexadecimal && text.size() > 1 &&
        text.find_first_not_of("0123456789") == std::string::npos && decimal.ok()) {
      wrong(fmt::format("write 0x{} or, if it is decimal, 0x{:X}", text, *decimal));
    }
    const Number word = is_word ? value_in(key, text) : std::nullopt;
    std::int64_t unknown = word.value_or(0);
    std::string_view rest = text;
    for (std::size_t i = first; i < rows.size() && rows[i].key == key.key; ++i) {
      const Parameter& row = rows[i];
      Number value;
      if (is_word) {
        const std::int64_t mask = (std::int64_t{1} << row.bits) - 1;
        if (word && *word <= UINT32_MAX) value = *word >> row.shift & mask;
        unknown &= ~(mask << row.shift);
      } else if (rest.starts_with(row.before)) {
        rest.remove_prefix(row.before.size());
        if (row.may_be_negative && rest.starts_with('-')) rest.remove_prefix(1);
        const std::size_t digits = rest.find_first_not_of("0123456789");
        const auto part = rest.substr(0, alone || !row.names.empty() ? rest.size() : digits);
        value = value_in(row, std::string(part));
        rest.remove_prefix(part.size());
      }
      if (!value || *value < row.low || *value > row.high ||
          (!row.codes.empty() && !row.codes.contains(*value))) {
        wrong(fmt::format("{}: {}", row.name, allowed_values(row)));
      }
      values[i] = value;
    }
    if (!is_word && !rest.empty()) wrong(fmt::format("'{}' is too much", rest));
    if (unknown != 0) wrong(fmt::format("the bits 0x{:X} have no meaning in this table", unknown));
  }
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
      FormatMaker{master, values}.crc_polynomial() == format.channel_list[0].crc.polynomial;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& row = master.parameters[i];
    if (!is_format(row) || row.key.empty() || values[i] == (*needed)[i]) continue;
    if (row.term == "status_off" && values[i] == 1) continue;
    if (same_crc && (row.term == "crc_usual" || row.term == "crc_field")) continue;
    // Nor is it certain which form of a polynomial this is.
    if (row.sure && row.term == "polynomial" && values[i] == *(*needed)[i] >> 1) continue;
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
  } else if (master.find("singleturn") == nullptr && !channel.multiturn.present()) {
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
    open.push_back(
        fmt::format("crc: polynomial{} are not in the settings",
                    master.open("crc") ? ", start value and inversion" : " and start value"));
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
  std::int64_t word = 0;
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
  SettingsReader reader{master};
  for (const std::string& setting : settings) reader.read(setting);
  const Values& given = reader.values;
  const Values values = reader.finish(found.assumed);
  if (expected) {
    found.format = *expected;
    for (const std::string& fact : open_facts(master, expected->channel_list[0])) {
      found.not_compared.push_back(fact.substr(0, fact.find(':')) + ": as in -f");
    }
  } else {
    const auto format = FormatMaker{master, values}.make();
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
          *values[i] * (milliseconds(1'000) / row.steps);
    } else if (expected && row.low != row.high &&
               (!is_format(row) ||
                (row.sure && row.term == "polynomial" && values[i] != row.sure))) {
      found.not_compared.push_back(fmt::format("{}: {}", row.key, row.name));
    }
  }
  return found;
}

}  // namespace biss::verbs
