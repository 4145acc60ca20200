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

FieldRow master_fields(const Master& master) {
  std::vector<std::string_view> keys;
  std::size_t uncertain = 0;
  for (const Parameter& row : master.parameters) {
    if (!row.key.empty() && (keys.empty() || keys.back() != row.key)) keys.push_back(row.key);
    if (row.uncertain()) ++uncertain;
  }
  return {{"name", master.name},       {"product", master.product},
          {"parameters", keys.size()}, {"uncertain", unless_0(uncertain)},
          {"place", master.place},     {"note", unless_empty(master.note)},
          {"source", master.source}};
}

ExitStatus list_masters(const SettingsOptions& options, Host& host) {
  return write_output(host, options.output, [&](Output& output) {
    std::vector<FieldRow> rows;
    for (const Master& master : masters()) {
      rows.push_back(master_fields(master));
      if (options.as_table()) rows.back().resize(4, rows.back().front());
    }
    return write_rows(rows, options.to, output);
  });
}

// ---- Settings for a format

LineTimes times_of(const SettingsOptions& options, const Device& device) {
  LineTimes times{.clock = options.clock};
  const bool known = device.timing_known();
  if (known || !options.arguments.ack_max.empty()) times.ack_max = device.timing.ack_max;
  const Timeout& timeout = device.timing.timeout;
  if (!options.arguments.timeout.empty() && timeout.rule == TimeoutRule::fixed) {
    times.timeout = timeout.time;
  }
  return times;
}

FieldRow setting_fields(const Master& master, const Setting& setting, bool as_table) {
  std::vector<std::string_view> names;
  std::vector<std::string_view> known;
  std::vector<std::string> doubts;
  for (const Parameter* row : setting.rows) {
    names.push_back(row->name);
    if (std::find(known.begin(), known.end(), row->known) == known.end())
      known.push_back(row->known);
    if (!row->doubt.empty()) doubts.emplace_back(row->doubt);
  }
  FieldRow fields{{"parameter", setting.rows.front()->key},
                  {"value", setting.value},
                  {"name", fmt::format("{}", fmt::join(names, "; "))},
                  {"known", fmt::format("{}", fmt::join(known, ", ")), {.heading = "known from"}}};
  if (as_table) return fields;
  fields.insert(fields.begin(), {"master", master.name});
  fields.insert(fields.end(), {{"doubt", fmt::format("{}", fmt::join(doubts, "; "))},
                               {"place", master.place},
                               {"source", master.source}});
  return fields;
}

std::string remarks(const Master& master, const std::vector<Setting>& settings, bool clock_given) {
  report::Summary out;
  out.entry("type it in", master.place);
  std::string_view heading = "not certain";
  for (const Setting& setting : settings) {
    for (const Parameter* row : setting.rows) {
      if (row->doubt.empty()) continue;
      out.entry(heading, row->key, row->doubt);
      heading = "";
    }
  }
  for (const Parameter& row : master.parameters) {
    const bool given = std::any_of(settings.begin(), settings.end(), [&](const Setting& setting) {
      return setting.rows.front()->key == row.key;
    });
    if (!clock_given && row.term == "clock") {
      out.entry("clock", row.key, given ? "the default is printed: give --clock" : "give --clock");
    }
    if (!given && row.term == "busy") out.entry("ACK", row.key, "give --ack-max");
    if (!given && row.term == "timeout") out.entry("timeout", row.key, "give --timeout static:…");
  }
  if (!master.note.empty()) out.entry("note", master.note);
  out.entry("source", master.source);
  return out.text();
}

// Settings, or the reason why the master cannot read the format, of every master.
ExitStatus show_all(const SettingsOptions& options, const Device& device, Host& host) {
  std::vector<FieldRow> rows;
  for (const Master& master : masters()) {
    const auto settings = settings_for(master, device.format, times_of(options, device));
    std::vector<std::string> texts;
    for (const Setting& each : settings ? *settings : std::vector<Setting>()) {
      texts.push_back(fmt::format("{}={}", each.rows.front()->key, each.value));
    }
    const std::string text = fmt::format("{}", fmt::join(texts, " "));
    rows.push_back({{"master", master.name},
                    {"settings", unless_empty(text)},
                    {"refused", unless_empty(settings ? "" : settings.error())}});
  }
  return write_output(host, options.output,
                      [&](Output& output) { return write_rows(rows, options.to, output); });
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
  return write_output(host, options.output, [&](Output& output) {
    return write_rows(rows, options.to, output) &&
           (!options.as_table() ||
            output.write("\n" + remarks(master, *settings, options.clock.has_value())));
  });
}

// ---- The format of settings

std::string page_of(const Found& found) {
  report::Summary out;
  const auto list = [&out](std::string_view heading, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      out.entry(&text == texts.data() ? heading : "", text);
    }
  };
  out.entry("format", format_text(found.format).view());
  if (found.times.clock) out.entry("clock", text_of(*found.times.clock, 3));
  if (found.times.ack_max) out.entry("ACK", "at most " + text_of(*found.times.ack_max));
  if (found.times.timeout) out.entry("timeout", text_of(*found.times.timeout));
  list("left out", found.assumed);
  list("open", found.open);
  return out.text();
}

ExitStatus show_format(const SettingsOptions& options, Host& host) {
  const Master& master = master_of(options.from);
  std::optional<FrameFormat> expected;
  if (!options.arguments.format.empty()) {
    expected = value_or_fail(choose_device(options.arguments)).format;
  }
  const Found found = format_of(master, options.settings, expected);
  return write_output(host, options.output, [&](Output& output) {
    if (options.as_table()) return output.write(page_of(found));
    return write_rows({{{"master", master.name},
                        {"format", format_text(found.format).view()},
                        {"clock_hz", found.times.clock},
                        {"ack_max_ns", found.times.ack_max},
                        {"timeout_ns", found.times.timeout},
                        {"left_out", fmt::format("{}", fmt::join(found.assumed, " "))},
                        {"open", fmt::format("{}", fmt::join(found.open, "; "))}}},
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
