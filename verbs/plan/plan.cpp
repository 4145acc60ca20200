// biss plan: the limits that a clock and a cable set for an encoder.
#include <fmt/format.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "biss/timing/renishaw.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {
namespace {

struct PlanOptions {
  FormatArguments arguments;
  std::optional<Hertz> clock;
  std::optional<Millimetres> cable;
  Picoseconds master_delay{};
  unsigned slaves = 1;
  report::Format to = report::Format::table;
  std::string output;
};

/// One encoder at one clock with one cable.
struct Plan {
  Device device;
  Hertz clock;
  Millimetres cable;
  Picoseconds master_delay;
  Picoseconds delay;
  CycleBudget budget;
  AckBounds ack;
  std::optional<Millimetres> longest_compensated;
  std::optional<Millimetres> longest_uncompensated;
  bool clock_ok = false;
  bool cable_ok = false;
  bool compensation = false;

  std::int64_t spi_bytes() const { return (budget.clocks_to_send + 7) / 8; }
};

Plan plan_for(const Device& device, Hertz clock, const PlanOptions& options) {
  const Millimetres cable = options.cable.value_or(Millimetres{});
  const Picoseconds other_delay = device.timing.internal_delay_max + options.master_delay;
  const Picoseconds delay = line_delay(cable, other_delay);
  const auto longest = cable_max_compensated(clock);
  return {.device = device,
          .clock = clock,
          .cable = cable,
          .master_delay = options.master_delay,
          .delay = delay,
          .budget = cycle_budget({device.format.payload_bits(), options.slaves}, device.timing,
                                 clock, delay),
          .ack = request_ack_bounds({.period = period_of(clock),
                                     .timing = device.timing,
                                     .slaves = static_cast<std::uint8_t>(options.slaves)}),
          .longest_compensated = longest,
          .longest_uncompensated = cable_max_uncompensated(clock, other_delay),
          .clock_ok = accepts_clock(device.timing, clock),
          .cable_ok = longest && cable <= *longest,
          .compensation = needs_compensation(clock, cable, other_delay)};
}

std::string fixed(std::int64_t number, unsigned shift, unsigned places) {
  std::string out;
  report::append_fixed(out, report::magnitude_of(number), shift, places);
  return out;
}

/// Thousandths of a clock, to the nearest one.
std::int64_t milliclocks(Picoseconds time, Picoseconds period) {
  // Whole periods are computed separately, because a time of hours times 1000 does not fit.
  return time.count / period.count * 1000 +
         (time.count % period.count * 1000 + period.count / 2) / period.count;
}

// In metres, as in data sheets.
std::string length_text(Millimetres length) {
  return fixed(length.count, 3,
               length.count % 1000 == 0  ? 0
               : length.count % 100 == 0 ? 1
                                         : 3) +
         " m";
}

std::string length_or(const std::optional<Millimetres>& length, std::string_view otherwise) {
  return length ? length_text(*length) : std::string(otherwise);
}

void warn_of(const Plan& plan, Host& host) {
  const DeviceTiming& timing = plan.device.timing;
  if (!plan.clock_ok) {
    host.warn(fmt::format("a clock of {} is outside the encoder's range of {} to {}",
                          text_of(plan.clock), text_of(timing.clock_min),
                          text_of(timing.clock_max)));
  }
  if (!plan.longest_compensated) {
    host.warn("no cable length is known for clocks above 10 MHz");
  } else if (!plan.cable_ok) {
    host.warn(fmt::format(
        "{} of cable is too long: at {} the limit is {} with line-delay compensation",
        length_text(plan.cable), text_of(plan.clock), length_text(*plan.longest_compensated)));
  }
}

/// The timeout rule, or the assumption if the frame is longer than the timeout.
std::string timeout_text(const Plan& plan) {
  const Timeout& timeout = plan.device.timing.timeout;
  const Picoseconds release = release_time(timeout, plan.budget.period);
  if (timeout.rule != TimeoutRule::cycle || plan.budget.timeout != release) return text_of(timeout);
  return fmt::format("{} ends within the frame: {} half periods assumed, see --release",
                     text_of(timeout), timeout.release_half_periods);
}

bool write_parts(const Plan& plan, Output& output) {
  const CycleBudget& budget = plan.budget;
  std::vector<FieldRow> rows;
  const auto add = [&rows](std::string_view part, Picoseconds time,
                           std::optional<std::int64_t> clocks, std::string_view what) {
    rows.push_back({{"part", part},
                    {"time", time, {.unit = "us", .shift = 3, .places = 3}},
                    {"clocks", clocks},
                    {"what", what}});
  };
  const auto in_clocks = [&](std::string_view part, Picoseconds time, std::string_view what) {
    add(part, time, time.count / budget.period.count, what);
  };
  in_clocks("LAT", budget.lat, "the first rising edge of MA");
  in_clocks("ACK", budget.ack,
            plan.device.timing.ack_clocks != 0 ? "fixed" : "longest, plus one clock in reserve");
  in_clocks("START, CDS", budget.start_cds, "");
  in_clocks("data, CRC", budget.payload, "");
  in_clocks("STOP", budget.stop, "");
  in_clocks("line delay", budget.line_delay,
            "cable (both ways), encoder and master, in whole clocks");
  add("timeout", budget.timeout, {}, timeout_text(plan));
  if (budget.idle != Picoseconds{}) {
    add("idle", budget.idle, {}, "until the encoder's shortest cycle has passed");
  }
  add("cycle", budget.total, {}, "shortest time from request to request");
  return write_rows(rows, report::Format::table, output);
}

bool is_renishaw(const Device& device) {
  if (device.entry != nullptr) return device.entry->vendor == "Renishaw";
  return device.configuration != nullptr && device.configuration->timing == renishaw_timing;
}

bool is_interpolated(const Plan& plan) {
  return is_renishaw(plan.device) && plan.longest_compensated && !is_published_clock(plan.clock);
}

// The source of the lengths of cable.
std::string_view lengths_text(const Plan& plan) {
  if (!plan.longest_compensated) return "not known";
  if (!is_renishaw(plan.device)) return "Renishaw's rule";
  if (is_interpolated(plan)) return "interpolated";
  return plan.master_delay == Picoseconds{} ? "data sheet" : "calculated";
}

void add_cable_facts(const Plan& plan, report::Summary& out) {
  out.entry("compensation", plan.compensation ? "needed" : "not needed",
            fmt::format("without it {} of cable, with it {}",
                        length_or(plan.longest_uncompensated, "no length"),
                        length_or(plan.longest_compensated, "an unknown length")));
  if (plan.clock > megahertz(5) && plan.clock < megahertz(10)) {
    out.entry("", "", "no length is published between 5 and 10 MHz: the length for 10 MHz is used");
  } else if (is_interpolated(plan)) {
    out.entry("", "", "the data sheet has no row for this clock: interpolated");
  }
  if (!is_renishaw(plan.device)) {
    out.entry("", "", "by Renishaw's rule; no other maker publishes one");
  }
  const Picoseconds margin = margin_uncompensated(plan.clock, plan.delay);
  out.entry("sampling margin",
            fmt::format("{} ns", fixed(margin_compensated(plan.clock).count, 3, 1)),
            "with compensation: half a period minus a quarter for changes of the line delay");
  out.entry("", fmt::format("{} ns", fixed(margin.count, 3, 1)),
            margin.count < 0 ? "without: every bit is sampled too early"
                             : "without: half a period minus the line delay");
}

// The notes at the table of cables, from the data sheet of BiSS Safety for frames of two words,
// otherwise from the data sheet of BiSS C.
void add_cable_notes(const Plan& plan, report::Summary& out) {
  if (!is_renishaw(plan.device)) return;
  out.entry(
      "cable notes", "Renishaw's only",
      "its readhead cable and approved extension cable; for FORTiS see its data sheet of cables");
  if (plan.device.format.channel_count > 1) {
    out.entry("", "above 50 m", "ask Renishaw");
  } else if (plan.device.entry->product.find("RESOLUTE") != std::string_view::npos) {
    out.entry("", "10 m at most", "the readhead's own cable; the rest is extension cable");
  }
  out.entry("", "5 V +-10 %", "the supply at the readhead");
  out.entry("", "master",
            plan.master_delay == Picoseconds{}
                ? std::string("its own delay is not in the lengths: give --master-delay")
                : fmt::format("its own delay of {} is counted; with compensation it is measured",
                              text_of(plan.master_delay)));
}

/// The rate for a master that waits until it sees SLO high, one line delay after the encoder.
Hertz rate_seen(const Plan& plan) {
  const std::int64_t cycle = (plan.budget.total + plan.delay).count;
  return hertz(static_cast<std::uint32_t>(picoseconds_per_second / cycle));
}

std::string_view seen_text(const Timeout& timeout) {
  return timeout.rule == TimeoutRule::cycle
             ? "for a master that waits until it sees SLO high"
             : "over SPI: the clocks of the line delay are sent before the timeout begins";
}

std::string facts(const Plan& plan) {
  const CycleBudget& budget = plan.budget;
  const DeviceTiming& timing = plan.device.timing;
  report::Summary out;
  out.entry("request rate", text_of(budget.request_rate_max), "at most");
  const bool by_time = timing.timeout.rule == TimeoutRule::cycle;
  if (by_time ? budget.total == timing.timeout.time : plan.delay.count != 0) {
    out.entry("", text_of(rate_seen(plan)), seen_text(timing.timeout));
  }
  out.entry("line delay", text_of(plan.delay),
            fmt::format("{} clocks; {} of cable {}, inside the encoder {}{}",
                        fixed(milliclocks(plan.delay, budget.period), 3, 3),
                        length_text(plan.cable), text_of(cable_delay(plan.cable)),
                        timing.internal_delay_max == Picoseconds{}
                            ? std::string("not known")
                            : fmt::format("at most {}", text_of(timing.internal_delay_max)),
                        plan.master_delay == Picoseconds{}
                            ? std::string()
                            : fmt::format(", master {}", text_of(plan.master_delay))));
  add_cable_facts(plan, out);
  const SamplingPoint point = sampling_point(plan.delay, budget.period);
  out.entry("sample at",
            fmt::format("{} clock{} + {}", point.whole_clocks, point.whole_clocks == 1 ? "" : "s",
                        text_of(point.rest, 1)),
            "after the rising edge of MA that shifts the bit out, with compensation");
  out.entry("SPI", fmt::format("{} bytes", plan.spi_bytes()),
            fmt::format("{} clocks: {} of the frame, {} of line delay", budget.clocks_to_send,
                        budget.frame_clocks, budget.clocks_to_send - budget.frame_clocks));
  const bool one_ack = plan.ack.min_clocks == plan.ack.max_clocks;
  out.entry("ACK",
            fmt::format("{}{} clocks", one_ack ? "" : fmt::format("{} to ", plan.ack.min_clocks),
                        plan.ack.max_clocks),
            "START outside this range is not from this encoder");
  if (timing.sampling_typical != Picoseconds{}) {
    out.entry("position sampled", text_of(timing.sampling_typical),
              fmt::format("after the first rising edge of MA ({} to {})",
                          text_of(timing.sampling_min), text_of(timing.sampling_max)));
  }
  add_cable_notes(plan, out);
  return out.text();
}

std::string heading(const Device& device) {
  const FormatText format = format_text(device.format);
  if (device.configuration != nullptr) {
    return fmt::format("{}  {}", device.configuration->name, format.view());
  }
  if (device.entry == nullptr) return std::string(format.view());
  return fmt::format("{} ({} {})  {}", device.entry->name, device.entry->vendor,
                     device.entry->product, format.view());
}

bool write_page(const Plan& plan, Output& output) {
  return output.write(fmt::format("{}\n{}, {} of cable\n\n", heading(plan.device),
                                  text_of(plan.clock), length_text(plan.cable))) &&
         write_parts(plan, output) && output.write("\n") && output.write(facts(plan));
}

FieldRow clock_fields(const Plan& plan) {
  return {{"clock", plan.clock, {.unit = "MHz", .shift = 6, .places = 2}},
          {"uncompensated",
           length_or(plan.longest_uncompensated, "-"),
           {.heading = "cable without", .unit = "compensation"}},
          {"compensated",
           length_or(plan.longest_compensated, "-"),
           {.heading = "cable with", .unit = "compensation"}},
          {"needed",
           !plan.cable_ok      ? "cable too long"
           : plan.compensation ? "needed"
                               : "not needed",
           {.heading = "compensation"}},
          {"cycle", plan.budget.total, {.unit = "us", .shift = 3, .places = 2}},
          {"rate", plan.budget.request_rate_max, {.heading = "request rate", .unit = "Hz"}},
          {"spi", plan.spi_bytes(), {.heading = "SPI", .unit = "bytes"}},
          {"lengths", lengths_text(plan), {.heading = "cable lengths"}}};
}

bool write_clocks(const std::vector<Plan>& plans, bool cable_given, Output& output) {
  const Plan& first = plans.front();
  const std::string cable =
      cable_given ? fmt::format("{} of cable", length_text(first.cable))
                  : "compensation, cycle, request rate and SPI bytes without a cable: give --cable";
  std::vector<FieldRow> rows;
  for (const Plan& plan : plans) rows.push_back(clock_fields(plan));
  report::Summary notes;
  add_cable_notes(first, notes);
  return output.write(fmt::format("{}\n{}\n\n", heading(first.device), cable)) &&
         write_rows(rows, report::Format::table, output) &&
         (notes.empty() || output.write("\n" + notes.text()));
}

// The machine output.
FieldRow plan_fields(const Plan& plan) {
  const CycleBudget& b = plan.budget;
  const auto length = [](auto value) { return value ? std::optional(value->count) : std::nullopt; };
  const SamplingPoint point = sampling_point(plan.delay, b.period);
  return {{"format", format_text(plan.device.format).view()},
          {"clock_hz", plan.clock},
          {"cable_mm", plan.cable.count},
          {"clock_ok", plan.clock_ok},
          {"cable_ok", plan.cable_ok},
          {"period_ns", b.period},
          {"lat_ns", b.lat},
          {"ack_ns", b.ack},
          {"start_cds_ns", b.start_cds},
          {"payload_ns", b.payload},
          {"stop_ns", b.stop},
          {"line_delay_ns", plan.delay},
          {"timeout_ns", b.timeout},
          {"idle_ns", b.idle},
          {"cycle_ns", b.total},
          {"request_rate_max_hz", b.request_rate_max},
          {"line_delay_milliclocks", milliclocks(plan.delay, b.period)},
          {"compensation_needed", plan.compensation},
          {"cable_max_mm_uncompensated", length(plan.longest_uncompensated)},
          {"cable_max_mm_compensated", length(plan.longest_compensated)},
          {"margin_uncompensated_ns", margin_uncompensated(plan.clock, plan.delay)},
          {"margin_compensated_ns", margin_compensated(plan.clock)},
          {"sample_whole_clocks", point.whole_clocks},
          {"sample_rest_ns", point.rest},
          {"frame_clocks", b.frame_clocks},
          {"clocks_to_send", b.clocks_to_send},
          {"spi_bytes", plan.spi_bytes()},
          {"ack_min_clocks", plan.ack.min_clocks},
          {"ack_max_clocks", plan.ack.max_clocks},
          {"request_rate_seen_hz", rate_seen(plan)},
          {"master_delay_ns", plan.master_delay},
          {"cable_lengths", lengths_text(plan)}};
}

// The usual clocks that the encoder accepts; all of them if it accepts none.
std::vector<Hertz> clocks_to_show(const PlanOptions& options, const DeviceTiming& timing) {
  if (options.clock) return {*options.clock};
  constexpr std::array clocks = {kilohertz(250), megahertz(1), kilohertz(1'500), megahertz(2),
                                 megahertz(3),   megahertz(4), megahertz(5),     megahertz(10)};
  std::vector<Hertz> shown;
  for (const Hertz clock : clocks) {
    if (accepts_clock(timing, clock)) shown.push_back(clock);
  }
  return shown.empty() ? std::vector<Hertz>(clocks.begin(), clocks.end()) : shown;
}

ExitStatus run_plan(const PlanOptions& options, Host& host) {
  const Device device = value_or_fail(choose_device(options.arguments));
  fail_if(wrong_slaves(options.slaves, device.format));
  if (options.master_delay > biss_line_delay_max) {
    throw wrong_usage("--master-delay: BiSS C allows a line delay of {}",
                      text_of(biss_line_delay_max));
  }
  std::vector<Plan> plans;
  for (const Hertz clock : clocks_to_show(options, device.timing)) {
    plans.push_back(plan_for(device, clock, options));
  }
  const bool one = options.clock && options.cable;
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    if (options.to == report::Format::jsonl) {
      std::vector<FieldRow> rows;
      for (const Plan& plan : plans) rows.push_back(plan_fields(plan));
      return write_rows(rows, options.to, output);
    }
    return one ? write_page(plans[0], output)
               : write_clocks(plans, options.cable.has_value(), output);
  });
  if (written == ExitStatus::done && options.clock) warn_of(plans[0], host);
  return written;
}

}  // namespace

void add_plan(Command& command) {
  const auto options = std::make_shared<PlanOptions>();
  Verb verb = command.add_verb(
      {.name = "plan",
       .purpose = "Compute what a clock and a cable allow: cycle time, request rate, compensation",
       .examples = {"biss plan -f resolute-26 --clock 10MHz --cable 50m",
                    "biss plan -f resolute-26",
                    "biss plan -f pos24,nE,nW,crc6 --ack-clocks 4 --timeout static:13.2us "
                    "--clock 5MHz --cable 3m"}},
      [options](Host& host) { return run_plan(*options, host); });
  add_format_option(verb, options->arguments, true);
  add_rate_option(verb, "--clock", into(options->clock),
                  "Frequency of MA; by default one line for each usual clock");
  add_length_option(verb, "--cable", into(options->cable),
                    "Cable length; 0 m by default, also in the table of the longest cables");
  add_duration_option(
      verb, "--master-delay", into(options->master_delay),
      "Delay of the master itself from MA to SLO: its drivers, receivers and logic; "
      "0s by default");
  add_count_option(
      verb, "--slaves", into(options->slaves),
      "Encoders in a daisy chain, each with a channel; 1 by default, also for BiSS Safety",
      max_channels);
  add_timing_options(verb, options->arguments);
  add_to_option(verb, options->to, {report::Format::table, report::Format::jsonl});
  add_output_option(verb, options->output);
}

}  // namespace biss::verbs
