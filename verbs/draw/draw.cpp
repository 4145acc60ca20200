// `biss draw`: request cycles of a capture, or of a simulated line, as text or as an SVG image.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "decode/cycle_edges.hpp"
#include "device/quantity.hpp"
#include "draw/cycle_drawing.hpp"
#include "draw/svg.hpp"
#include "draw/text.hpp"
#include "report/summary.hpp"
#include "sim/line.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/explain/drawing.hpp"
#include "verbs/simulate/fault_option.hpp"
#include "verbs/simulate/setup.hpp"

namespace biss::verbs {

namespace {

struct DrawOptions {
  CaptureArguments capture;
  LineOptions line;
  std::optional<std::uint64_t> ack_clocks;
  std::optional<std::uint64_t> cycle;
  std::uint64_t count = 1;
  std::optional<std::uint64_t> width;
  std::vector<draw::Mark> marks;
  std::string output;
  std::string to;
  /// Options of the simulated line alone.
  std::vector<const Option*> of_line;
  std::optional<Verb> verb;
};

constexpr std::uint64_t count_max = 100;
constexpr std::uint64_t text_width_min = 60;
constexpr std::size_t text_width_usual = 80;

std::string drawn_time(Picoseconds time) { return text_of(time, 3); }

// A cycle, and the faults that were injected into it.
struct SimulatedDrawing {
  draw::CycleDrawing drawing;
  std::string faults;
};

// More than enough for every fault; a longer line is drawn from a capture.
constexpr std::uint64_t simulated_cycles_max = 10'000;

std::uint64_t first_fault(const sim::LineSetup& setup) {
  std::optional<std::uint64_t> first;
  for (const sim::FaultRule& rule : setup.faults) {
    if (rule.cycle) first = std::min(first.value_or(*rule.cycle), *rule.cycle);
  }
  return first.value_or(0);
}

// Faults of the requests that a drawn cycle begins with: it may begin with a pulse.
std::string faults_of(const std::vector<sim::SimulatedCycle>& requests, Picoseconds time) {
  const auto after =
      std::find_if(requests.begin(), requests.end(),
                   [&](const sim::SimulatedCycle& request) { return request.time > time; });
  if (after == requests.begin()) return {};
  const sim::SimulatedCycle& request = *std::prev(after);
  const std::string placed = text_of(request.injected);
  return placed.empty() ? sim::text_of(request.faults) : placed;
}

// Runs the line up to this many requests, and draws the cycles from `first` on.
std::vector<SimulatedDrawing> run_line(const sim::LineSetup& setup, std::uint64_t first,
                                       std::uint64_t requests) {
  std::vector<SimulatedDrawing> drawn;
  const decode::MarginSetup margin{.compensated = setup.compensate};
  decode::CycleEdgeReader reader(
      decode::CycleReader(setup.format, setup.timing, margin),
      {.ma = sim::ma_line, .slo = sim::slo_line}, [&](const decode::CycleEdges& edges) {
        if (edges.number < first || drawn.size() >= requests - first) return;
        drawn.push_back(
            {draw::draw_cycle(edges, setup.format, setup.timing, margin, draw::DrawnExtent::cycle),
             {}});
      });
  const wire::Edge idle[] = {{{}, sim::ma_line, wire::Level::high},
                             {{}, sim::slo_line, wire::Level::high}};
  reader.push(idle);
  sim::Line line(setup);
  std::vector<sim::SimulatedCycle> kept;
  for (std::uint64_t i = 0; i < requests; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    reader.push(cycle.edges);
    if (i + 1 < first) continue;
    kept.push_back(cycle);
    kept.back().edges.clear();
  }
  reader.finish(line.end());
  for (SimulatedDrawing& each : drawn) each.faults = faults_of(kept, each.drawing.cycle.time);
  return drawn;
}

// Clocks from ACK to START, if START was found.
std::optional<std::size_t> ack_of(const draw::CycleDrawing& drawing) {
  for (const draw::DrawnBit& bit : drawing.bits) {
    if (bit.name == "START") return bit.clock - 1;
  }
  return std::nullopt;
}

class DrawRun {
 public:
  DrawRun(const DrawOptions& options, Host& host)
      : options_(options),
        host_(host),
        svg_(options.to.empty() ? options.output.ends_with(".svg") : options.to == "svg") {}

  ExitStatus run() {
    if (options_.count == 0) throw wrong_usage("--count: 1 to 100");
    if (options_.ack_clocks == 0) throw wrong_usage("--ack: 1 to 1000");
    const std::uint64_t least = svg_ ? draw::svg_width_min : text_width_min;
    if (options_.width.value_or(least) < least) {
      throw wrong_usage("--width: at least {} {}", least, svg_ ? "pixels" : "columns");
    }
    const CaptureArguments& capture = options_.capture;
    const bool has_capture = !capture.files.empty() || !capture.ma.empty() || !capture.slo.empty();
    const ExitStatus drawn = has_capture ? draw_captures() : draw_line();
    if (drawn != ExitStatus::done) return drawn;
    warn_of_marks();
    return write_output(host_, options_.output, [&](Output& output) {
      return output.write(svg_ ? draw::svg_text(panels_, svg_width()) : text());
    });
  }

 private:
  std::size_t width_or(std::size_t usual) const {
    constexpr std::uint64_t most = std::numeric_limits<std::size_t>::max();
    return static_cast<std::size_t>(std::min<std::uint64_t>(options_.width.value_or(usual), most));
  }
  std::size_t svg_width() const { return width_or(draw::svg_width_usual); }
  std::size_t columns() const {
    const std::size_t terminal = output_columns(host_);
    return width_or(terminal == 0 || !options_.output.empty() ? text_width_usual : terminal);
  }

  void add_panel(draw::CycleDrawing drawing, const std::optional<FrameFormat>& format,
                 const std::string& faults = {}) {
    std::string title = drawing_title(drawing);
    title.pop_back();
    if (!faults.empty()) title += ", injected: " + faults;
    panels_.push_back(
        {std::move(title), draw::lay_out(std::move(drawing), format, drawn_time, options_.marks)});
  }

  void warn_of_marks() const {
    for (const draw::Mark& mark : options_.marks) {
      const bool shown = std::any_of(panels_.begin(), panels_.end(), [&](const draw::Panel& panel) {
        const draw::CycleDrawing& drawing = panel.layout.drawing;
        return mark.time >= drawing.cycle.time && mark.time <= drawing.end;
      });
      if (!shown) {
        host_.warn(
            fmt::format("--mark: {} is not within the cycles drawn; left out", text_of(mark.time)));
      }
    }
  }

  ExitStatus draw_line() {
    LineOptions line = options_.line;
    line.device = options_.capture.device;
    if (line.device.format.empty()) {
      throw wrong_usage("no capture given; name a file, or give -f to draw a simulated cycle");
    }
    if (line.device.format == "none") {
      throw wrong_usage("-f none: a simulated cycle needs a format");
    }
    for (const Option* option : options_.verb->given_options()) {
      if (option->scope == Scope::file) {
        throw wrong_usage("{}: describes a capture; name one, or leave it out", option->name());
      }
    }
    sim::LineSetup setup = value_or_fail(line_setup(line));
    fail_if(wrong_start(setup));
    if (options_.ack_clocks) {
      const Picoseconds period = period_of(line.setup.clock);
      setup.processing = static_cast<std::int64_t>(*options_.ack_clocks) * period - period / 2;
    }
    // From cycle --cycle on; by default from the first one that a fault is injected into by its
    // number.
    const std::uint64_t begin = options_.cycle.value_or(first_fault(setup));
    const std::uint64_t requests = begin + options_.count;
    if (requests > simulated_cycles_max) {
      throw wrong_usage("--cycle: a simulated line has {} cycles here; draw a capture",
                        simulated_cycles_max);
    }
    fail_if(wrong_faults(setup.faults, sim::Line(setup).nominal(), requests));
    std::vector<SimulatedDrawing> cycles = run_line(setup, begin, requests);
    if (cycles.empty()) {
      return host_.fail(
          ExitStatus::data_failed,
          fmt::format("no cycle {}: with these faults fewer cycles are on the line", begin));
    }
    const auto ack = ack_of(cycles.front().drawing);
    if (options_.ack_clocks && setup.faults.empty() && ack && *ack != *options_.ack_clocks) {
      throw wrong_usage("--ack: this encoder answers after {} at {}, not after {}",
                        report::counted(*ack, "clock"), text_of(line.setup.clock),
                        *options_.ack_clocks);
    }
    for (SimulatedDrawing& cycle : cycles) {
      add_panel(std::move(cycle.drawing), setup.format, cycle.faults);
    }
    return ExitStatus::done;
  }

  ExitStatus draw_captures() {
    for (const Option* option : options_.of_line) {
      if (!option->given.empty()) {
        throw wrong_usage("{}: describes a simulated line; leave it out, or the capture",
                          option->name());
      }
    }
    CaptureArguments arguments = options_.capture;
    arguments.identify = true;
    const ExitStatus opened = capture_.open(arguments);
    if (opened != ExitStatus::done) return opened;
    while (capture_.next()) {
      const ExitStatus drawn = draw_capture();
      if (drawn != ExitStatus::done) return drawn;
    }
    return capture_.status();
  }

  ExitStatus draw_capture() {
    if (options_.capture.device.format.empty()) {
      host_.warn(capture_.format()
                     ? fmt::format("{}: drawn with the format that its frames show, -f '{}'",
                                   capture_.input().name(), text_of(*capture_.format()))
                     : fmt::format("{}: its frames show no certain format; bits have no names, "
                                   "give -f",
                                   capture_.input().name()));
    }
    const std::uint64_t first = options_.cycle.value_or(0);
    const std::size_t before = panels_.size();
    std::uint64_t cycles = 0;
    decode::CycleEdgeReader reader(
        capture_.reader(), capture_.lines().lines, [&](const decode::CycleEdges& edges) {
          cycles = edges.number + 1;
          if (edges.number < first || edges.number - first >= options_.count) return;
          add_panel(draw::draw_cycle(edges, capture_.format(), capture_.timing(), capture_.margin(),
                                     draw::DrawnExtent::cycle),
                    capture_.format());
        });
    const auto done = [&] { return panels_.size() - before == options_.count; };
    const bool whole = capture_.read_edges([&](std::span<const wire::Edge> edges) {
      reader.push(edges);
      return !done();
    });
    if (!done()) reader.finish(capture_.input().end_time());
    if (done()) return ExitStatus::done;
    if (!whole) return host_.fail(ExitStatus::io, capture_.input().error());
    return host_.fail(
        ExitStatus::data_failed,
        fmt::format("{}: no cycle {}; the capture has {}, counted from 0", capture_.input().name(),
                    std::max(first, cycles), report::counted(cycles, "request cycle")));
  }

  std::string text() const {
    std::string text;
    for (const draw::Panel& panel : panels_) {
      if (!text.empty()) text += '\n';
      text += panel.title + "\n\n" + draw::layout_text(panel.layout, columns());
    }
    return text;
  }

  const DrawOptions& options_;
  Host& host_;
  bool svg_;
  DecodedCapture capture_{host_};
  std::vector<draw::Panel> panels_;
};

constexpr std::size_t mark_size_max = 40;

// TIME=NAME.
draw::Mark read_mark(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = equals == std::string::npos ? "" : text.substr(equals + 1);
  const bool printable =
      std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (name.empty() || name.size() > mark_size_max || !printable) {
    wrong_value("--mark", fmt::format("'{}': give TIME=NAME, the name with at most {} characters "
                                      "of ASCII",
                                      text, mark_size_max));
  }
  const std::string time = text.substr(0, equals);
  const auto read = parse_time(time);
  if (!read.ok()) wrong_value("--mark", quantity_error_text(Quantity::time, time, read.error()));
  return {*read, name};
}

void add_line_options(Verb verb, DrawOptions& options) {
  LineOptions& line = options.line;
  options.of_line = {
      &add_rate_option(verb, "--clock", into(line.setup.clock),
                       "Frequency of MA; 1 MHz by default"),
      &add_duty_option(verb, "--duty", into(line.setup.duty_per_mille),
                       "Share of a period in which MA is high; 50% by default"),
      &add_length_option(verb, "--cable", into(line.cable),
                         "Cable length; 10 ns of line delay per metre"),
      &add_duration_option(verb, "--jitter", into(line.jitter),
                           "Peak edge jitter (±), both directions"),
  };
  Option& ack = add_count_option(verb, "--ack", into(options.ack_clocks),
                                 "Clocks from ACK to START; the encoder's fewest by default", 1000);
  ack.type_name("CLOCKS");
  Option& processing =
      add_duration_option(verb, "--processing", into(line.processing),
                          "Processing time, from ACK to START; the encoder's shortest by default");
  ack.excludes(processing);
  options.of_line.insert(
      options.of_line.end(),
      {&ack, &processing,
       &verb.add_flag("--no-compensation", line.no_compensation,
                      "The master does not compensate the line delay; the bits are drawn as decode "
                      "samples them"),
       &add_count_option(verb, "--position", into(line.setup.position),
                         "Position of the encoder; drawn from --seed by default"),
       &add_count_option(verb, "--seed", into(line.setup.seed),
                         "Random seed of the position, jitter and faults; 1 by default"),
       &verb.add_option("--fault", line.faults, "Inject a fault, as in biss simulate: flip@0,bit=7")
            .type_name("KIND@CYCLE[,PLACE]")});
}

}  // namespace

void add_draw(Command& command) {
  const auto options = std::make_shared<DrawOptions>();
  Verb verb = command.add_verb(
      {.name = "draw",
       .purpose =
           "Draw a request cycle as text or SVG, from a capture or from a format and a timing",
       .examples = {"biss draw capture.vcd -f resolute-26 --cycle 3",
                    "biss draw capture.vcd -f resolute-26 --cycle 3 -o cycle.svg",
                    "biss draw -f pos12,nE,nW,crc6 --clock 5MHz --ack 12 --cable 20m "
                    "--position 1234 -o cycle.svg",
                    "biss draw -f resolute-18 --fault flip@0,bit=7"}},
      [options](Host& host) { return DrawRun(*options, host).run(); });
  add_capture_options(verb, options->capture);
  options->verb = verb;
  add_count_option(verb, "--cycle", into(options->cycle),
                   "Cycle to draw, counted from 0 as the rows of decode; 0 by default, or the "
                   "first one of --fault")
      .type_name("N");
  add_count_option(verb, "--count", into(options->count), "Cycles to draw; 1 by default", count_max)
      .type_name("K");
  add_count_option(
      verb, "--width", into(options->width),
      "Width: columns of text, 80 or the width of the terminal by default; pixels of an "
      "image, 960 by default",
      draw::svg_width_max)
      .type_name("N");
  verb.add_text_option(
          "--mark",
          [options](const std::string& text) { options->marks.push_back(read_mark(text)); },
          "Mark a moment of the capture by a name: 12.5us=ready", true)
      .type_name("TIME=NAME");
  add_output_option(verb, options->output);
  add_name_option(verb, "--to", options->to, {"text", "svg"},
                  "Output format; by default svg if the output file ends with .svg, else text");
  add_line_options(verb.section("Simulated line"), *options);
}

}  // namespace biss::verbs
