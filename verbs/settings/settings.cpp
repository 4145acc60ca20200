// biss settings: a frame format as the parameters of a drive, a controller or a chip, and back.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/timing/cycle.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/settings/exchange.hpp"
#include "verbs/settings/masters.hpp"

namespace biss::verbs {
namespace {

struct SettingsOptions {
  FormatArguments arguments;
  std::string master;
  std::string from;
  std::vector<std::string> settings;
  std::optional<Hertz> clock;
  report::Format to = report::Format::table;
  std::string output;

  bool as_table() const { return to == report::Format::table; }
};

// ---- The masters

FieldRow master_fields(const Master& master, bool as_table) {
  std::uint64_t uncertain = 0;
  for (const Parameter& row : master.parameters) uncertain += row.uncertain() ? 1U : 0U;
  FieldRow fields{{"name", master.name},
                  {"product", master.product},
                  {"parameters", master.keys().size()},
                  {"uncertain", unless_0(uncertain)},
                  {"place", master.place},
                  {"note", unless_empty(master.note)},
                  {"source", master.source}};
  if (as_table) fields.resize(4, fields.front());
  return fields;
}

ExitStatus list_masters(const SettingsOptions& options, Host& host) {
  return write_output(host, options.output, [&](Output& output) {
    return write_rows(masters(), options.to, output, [&](const Master& master) {
      return master_fields(master, options.as_table());
    });
  });
}

// ---- Settings for a format

// The longest ACK, if it is known.
std::optional<Picoseconds> ack_of(const SettingsOptions& options, const Device& device,
                                  std::optional<Hertz> clock) {
  const std::uint16_t clocks = device.timing.ack_clocks;
  if (clocks != 0 && clock) return clocks * period_of(*clock);
  const bool known = device.timing_known() || !options.arguments.ack_max.empty();
  return known && clocks == 0 ? std::optional(device.timing.ack_max) : std::nullopt;
}

LineTimes times_of(const SettingsOptions& options, const Device& device) {
  const Timeout& timeout = device.timing.timeout;
  const bool given = !options.arguments.timeout.empty() && timeout.rule == TimeoutRule::fixed;
  return {.clock = options.clock,
          .ack_max = ack_of(options, device, options.clock),
          .timeout = given ? std::optional(timeout.time) : std::nullopt};
}

FieldRow setting_fields(const Master& master, const Setting& setting, bool as_table) {
  std::vector<std::string_view> names;
  std::vector<std::string_view> known;
  for (const Parameter* row : setting.rows) {
    names.push_back(row->name);
    const bool is_new = std::find(known.begin(), known.end(), row->known) == known.end();
    if (is_new) known.push_back(row->known);
  }
  FieldRow fields{{"parameter", setting.rows.front()->key},
                  {"value", setting.value},
                  {"name", fmt::format("{}", fmt::join(names, "; "))},
                  {"known", fmt::format("{}", fmt::join(known, ", ")), {.heading = "known from"}}};
  if (as_table) return fields;
  fields.insert(fields.begin(), {"master", master.name});
  fields.insert(fields.end(), {{"doubt", fmt::format("{}", fmt::join(setting.doubts, "; "))},
                               {"place", master.place},
                               {"note", master.note},
                               {"source", master.source}});
  return fields;
}

using Remarks = std::vector<std::pair<std::string_view, std::string>>;

// A line for each, with its heading.
std::string lines_of(const Remarks& remarks) {
  report::Summary out;
  std::string_view last;
  for (const auto& [heading, text] : remarks) {
    out.entry(heading == last ? "" : heading, text);
    last = heading;
  }
  return out.text();
}

// Doubts, facts that the user must give, and facts that no source has.
Remarks remarks_of(const Master& master, const std::vector<Setting>& settings, bool clock_given) {
  Remarks remarks;
  for (const Setting& setting : settings) {
    for (const std::string_view doubt : setting.doubts) {
      remarks.emplace_back("not certain", fmt::format("{}: {}", setting.rows.front()->key, doubt));
    }
  }
  const auto give = [&](std::string_view heading, const Parameter& row, std::string_view what) {
    remarks.emplace_back(heading, fmt::format("{}: give {}", row.key, what));
  };
  for (const Parameter& row : master.parameters) {
    const bool given = std::any_of(settings.begin(), settings.end(), [&](const Setting& setting) {
      return setting.rows.front()->key == row.key;
    });
    if (!clock_given && row.term == "clock") {
      give("clock", row, given ? "--clock, this is the default" : "--clock");
    }
    if (!given && row.term == "busy") give("ACK", row, "--ack-max");
    if (!given && row.term == "timeout") give("timeout", row, "--timeout static:…");
  }
  if (clock_given && master.find("clock") == nullptr) {
    remarks.emplace_back("clock", "no setting for it is known");
  }
  if (master.assumes("crc")) {
    remarks.emplace_back("assumed", "crc6:0x43, start 0, inverted: no source");
  }
  if (master.assumes("status")) {
    remarks.emplace_back("assumed", "nE,nW are evaluated: no source");
  }
  if (!master.note.empty()) remarks.emplace_back("note", master.note);
  return remarks;
}

// Settings, or the reason why the master cannot read the format, of every master.
ExitStatus show_all(const SettingsOptions& options, const Device& device, Host& host) {
  const auto fields_of = [&](const Master& master) -> FieldRow {
    const auto settings = settings_for(master, device.format, times_of(options, device));
    std::vector<std::string> texts;
    std::vector<std::string> remarks;
    if (settings) {
      for (const Setting& each : *settings) {
        texts.push_back(fmt::format("{}={}", each.rows.front()->key, each.value));
      }
      for (const auto& [heading, text] : remarks_of(master, *settings, options.clock.has_value())) {
        remarks.push_back(fmt::format("{}: {}", heading, text));
      }
    }
    return {{"master", master.name},
            {"settings", unless_empty(fmt::format("{}", fmt::join(texts, " ")))},
            {"refused", unless_empty(settings ? "" : settings.error())},
            {"remarks", unless_empty(fmt::format("{}", fmt::join(remarks, "; ")))}};
  };
  return write_output(host, options.output, [&](Output& output) {
    return write_rows(masters(), options.to, output, fields_of);
  });
}

ExitStatus show_settings(const SettingsOptions& options, Host& host) {
  const Device device = value_or_fail(choose_device(options.arguments));
  if (options.clock && !accepts_clock(device.timing, *options.clock)) {
    throw wrong_usage("--clock: the encoder does not accept {}", text_of(*options.clock));
  }
  if (options.master == "all") return show_all(options, device, host);
  const Master& master = master_of(options.master);
  const auto settings = settings_for(master, device.format, times_of(options, device));
  if (!settings) {
    throw wrong_usage("{}: {} (format {})", master.name, settings.error(),
                      format_text(device.format).view());
  }
  std::vector<FieldRow> rows;
  for (const Setting& each : *settings) {
    rows.push_back(setting_fields(master, each, options.as_table()));
  }
  Remarks remarks = remarks_of(master, *settings, options.clock.has_value());
  remarks.emplace(remarks.begin(), "type it in", master.place);
  remarks.emplace_back("source", master.source);
  return write_output(host, options.output, [&](Output& output) {
    return write_rows(rows, options.to, output) &&
           (!options.as_table() || output.write("\n" + lines_of(remarks)));
  });
}

// ---- The format of settings

std::string page_of(const Found& found) {
  Remarks lines{{"format", std::string(format_text(found.format).view())}};
  const auto list = [&](std::string_view heading, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) lines.emplace_back(heading, text);
  };
  const auto& [clock, ack, timeout] = found.times;
  if (clock) lines.emplace_back("clock", text_of(*clock, 3));
  if (ack) lines.emplace_back("ACK", "at most " + text_of(*ack));
  if (timeout) lines.emplace_back("timeout", text_of(*timeout) + ", of the drive");
  list("left out", found.assumed);
  list("not certain", found.doubts);
  list("open", found.open);
  list("not compared", found.not_compared);
  return lines_of(lines);
}

// Refuses options that are not compared with the settings.
void refuse_options(const SettingsOptions& options, const Master& master) {
  const FormatArguments& given = options.arguments;
  const auto refuse = [&](const std::string& value, std::string_view option, const char* term) {
    if (value.empty() || (!given.format.empty() && master.find(term) != nullptr)) return;
    throw wrong_usage("{}: is not compared with these settings", option);
  };
  refuse(options.clock ? "given" : "", "--clock", "");
  refuse(given.timeout, "--timeout", "");
  refuse(given.release, "--release", "");
  refuse(given.cycle_min, "--cycle-min", "");
  refuse(given.clock_max, "--clock-max", "clock");
  refuse(given.ack_max, "--ack-max", "busy");
  refuse(given.ack_clocks, "--ack-clocks", "busy");
}

// Compares clock and ACK of the drive with the encoder.
void compare_times(const SettingsOptions& options, const Device& device, Found& found) {
  const auto fail = [&](const std::string& why) {
    throw wrong_usage("{}: contradiction: {}{}{}", options.from, why,
                      found.doubts.empty() ? "" : "; not certain: ", fmt::join(found.doubts, "; "));
  };
  const auto skip = [&found](std::string_view why) { found.not_compared.emplace_back(why); };
  const std::optional<Hertz> clock = found.times.clock;
  const bool limits_known = device.timing_known() || !options.arguments.clock_max.empty();
  if (!clock) {
    skip("clock: not in the settings");
  } else if (!accepts_clock(device.timing, *clock)) {
    fail(fmt::format("the encoder does not accept the clock {}", text_of(*clock, 3)));
  } else if (!limits_known) {
    skip("clock: -f has only the limits of BiSS C");
  }
  const std::optional<Picoseconds> ack = ack_of(options, device, clock);
  if (!found.times.ack_max) {
    skip("ACK: not in the settings");
  } else if (!ack) {
    skip("ACK: not known from -f");
  } else if (*found.times.ack_max < *ack) {
    fail(fmt::format("the drive waits {} for START, the ACK of the encoder takes up to {}",
                     text_of(*found.times.ack_max), text_of(*ack)));
  }
  skip("timeout");
}

ExitStatus show_format(const SettingsOptions& options, Host& host) {
  if (options.from == "all") throw wrong_usage("--from: 'all' is for --for; give the name of one");
  const Master& master = master_of(options.from);
  if (options.settings.empty()) throw wrong_usage("--from: needs KEY=VALUE");
  refuse_options(options, master);
  std::optional<Device> device;
  if (!options.arguments.format.empty()) device = value_or_fail(choose_device(options.arguments));
  Found found =
      format_of(master, options.settings, device ? std::optional(device->format) : std::nullopt);
  if (device) compare_times(options, *device, found);
  return write_output(host, options.output, [&](Output& output) {
    if (options.as_table()) return output.write(page_of(found));
    return write_rows({{{"master", master.name},
                        {"format", format_text(found.format).view()},
                        {"clock_hz", found.times.clock},
                        {"ack_max_ns", found.times.ack_max},
                        {"timeout_ns", found.times.timeout},
                        {"left_out", fmt::format("{}", fmt::join(found.assumed, " "))},
                        {"doubt", fmt::format("{}", fmt::join(found.doubts, "; "))},
                        {"open", fmt::format("{}", fmt::join(found.open, "; "))},
                        {"not_compared", fmt::format("{}", fmt::join(found.not_compared, "; "))}}},
                      options.to, output);
  });
}

ExitStatus run_settings(const SettingsOptions& options, Host& host) {
  if (!options.from.empty()) return show_format(options, host);
  if (!options.settings.empty()) throw wrong_usage("KEY=VALUE: needs --from NAME");
  if (!options.master.empty()) {
    if (options.arguments.format.empty()) throw wrong_usage("--for: needs -f FORMAT");
    return show_settings(options, host);
  }
  if (!options.arguments.format.empty()) throw wrong_usage("-f: needs --for NAME or --for all");
  return list_masters(options, host);
}

}  // namespace

void add_settings(Command& command) {
  const auto options = std::make_shared<SettingsOptions>();
  Verb verb = command.add_verb(
      {.name = "settings",
       .purpose = "Show what to type into a drive or controller for a frame format, and back",
       .examples = {"biss settings -f resolute-26 --for el5042 --clock 10MHz",
                    "biss settings -f mt12,st19,nE,nW,crc6 --for all",
                    "biss settings --from ti-am243x single_turn_len=19 multi_turn_len=12",
                    "biss settings --from geo-brick 'channel=$211492' -f resolute-18",
                    "biss settings"}},
      [options](Host& host) { return run_settings(*options, host); });
  add_format_option(verb, options->arguments, false,
                    "; with --from: takes the place of what the settings leave open");
  Option& master = verb.add_option("--for", options->master,
                                   "Print the settings of this master for -f; 'all' for every one")
                       .type_name("NAME");
  verb.add_option("--from", options->from,
                  "Print the format of the settings KEY=VALUE of this master")
      .type_name("NAME")
      .excludes(master);
  verb.add_option("KEY=VALUE", options->settings,
                  "Settings of the master of --from; a key may be its last part, as :15");
  add_rate_option(verb, "--clock", into(options->clock),
                  "Frequency of MA, if the master has a setting for it");
  add_timing_options(verb, options->arguments);
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
}

}  // namespace biss::verbs
