#include "tests/other_lines/score.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/catalogue/catalogue.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "sim/line.hpp"
#include "tests/other_lines/generators.hpp"

namespace biss::other_lines {

using identify::Protocol;

const std::array<Kind, 14> kinds{{
    {"SSI", 140, Protocol::ssi, draw_ssi},
    {"EnDat 2.1, 2.2", 110, Protocol::endat22, draw_endat},
    {"HIPERFACE DSL", 40, Protocol::hiperface_dsl, draw_dsl},
    {"Tamagawa, Panasonic", 90, Protocol::serial_encoder, draw_tamagawa},
    {"Nikon", 40, Protocol::serial_encoder, draw_nikon},
    {"SPI", 200, Protocol::spi, draw_spi},
    {"I2C", 100, Protocol::i2c, draw_i2c},
    {"UART", 90, Protocol::uart, draw_uart},
    {"Modbus", 30, Protocol::uart, draw_modbus},
    {"quadrature", 30, Protocol::quadrature, draw_quadrature},
    {"PWM", 20, Protocol::unknown, draw_pwm},
    {"clock alone", 50, Protocol::clock_alone, draw_clock_alone},
    {"noise", 50, Protocol::noise, draw_noise},
    {"idle", 10, Protocol::idle, draw_idle},
}};

namespace {

constexpr std::string_view biss_name = "BiSS C";

sim::LineSetup biss_setup(Dice& dice, std::string& note) {
  while (true) {
    const CatalogueEntry& entry = catalogue[static_cast<std::size_t>(
        dice.between(0, static_cast<std::int64_t>(catalogue.size()) - 1))];
    const Hertz clock{static_cast<std::uint32_t>(dice.decades(80e3, 10e6))};
    const std::int64_t length = dice.between(0, 100);
    if (!accepts_clock(entry.timing, clock) || metres(length) > cable_max_compensated(clock))
      continue;
    sim::LineSetup setup;
    setup.format = entry.frame_format();
    setup.timing = entry.timing;
    setup.clock = clock;
    setup.internal_delay = entry.timing.internal_delay_max;
    setup.ma_delay = setup.slo_delay = cable_delay(metres(length)) / 2;
    setup.motion = static_cast<sim::MotionKind>(dice.between(0, 4));
    setup.processing = nanoseconds(dice.between(0, entry.timing.ack_max.count / 1000));
    if (entry.timing.ack_clocks != 0) setup.processing = {};
    if (dice.chance(50))
      setup.interval = sim::least_interval(setup) + microseconds(dice.between(0, 300));
    setup.duty_per_mille = static_cast<std::uint32_t>(dice.between(440, 560));
    setup.ma_jitter = std::min(setup.ma_delay, period_of(clock) * dice.between(0, 10) / 1000);
    setup.slo_jitter = std::min(setup.slo_delay, period_of(clock) * dice.between(0, 10) / 1000);
    setup.seed = dice.bits(32);
    const std::int64_t damage = dice.chance(40) ? dice.between(1, 100) : 0;
    if (damage != 0) {
      const auto kind = static_cast<sim::FaultKind>(
          dice.between(0, static_cast<std::int64_t>(sim::FaultKind::frozen)));
      setup.faults = {{.kind = kind, .share = static_cast<std::uint64_t>(damage) * 4'294'967U}};
    }
    note = fmt::format("{} {} kHz, {} m, {}, processing {} ns, {} per mille damaged", entry.name,
                       clock.count / 1000, length,
                       sim::motion_names[static_cast<std::size_t>(setup.motion)],
                       setup.processing.count / 1000, damage);
    if (damage != 0)
      note += fmt::format(" by {}",
                          sim::fault_list[static_cast<std::size_t>(setup.faults[0].kind)].name);
    return setup;
  }
}

}  // namespace

Capture biss_capture(Dice& dice) {
  std::string note;
  const sim::LineSetup setup = biss_setup(dice, note);
  sim::Line line(setup);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(true)};
  const std::int64_t cycles = dice.between(25, 120);
  for (std::int64_t i = 0; i < cycles; ++i) {
    for (const wire::Edge& edge : line.next().edges) {
      drawing.lines[edge.line].set(edge.time, edge.level == wire::Level::high);
    }
  }
  drawing.end = line.end();
  drawing.finest = period_of(setup.clock);
  drawing.note = std::move(note);
  return captured(drawing, dice);
}

Row Score::row(std::string_view name) const {
  return *std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.name == name; });
}

namespace {

void judge(const Capture& capture, std::string_view id, Row& row, std::string& wrong) {
  const auto guesses = identify::recognise_protocol(capture.edges, capture.lines,
                                                    capture.sample_period, capture.end);
  const auto biss = std::find_if(guesses.begin(), guesses.end(), [](const auto& guess) {
    return guess.protocol == Protocol::biss_c;
  });
  const double confidence = biss == guesses.end() ? 0 : biss->confidence;
  const Protocol best = guesses.front().protocol;
  ++row.all;
  ++row.counts[static_cast<std::size_t>(best)];
  row.least_biss = std::min(row.least_biss, confidence);
  const bool is_biss = row.protocol == Protocol::biss_c;
  if (!is_biss && confidence >= 0.5) ++row.taken_for_biss;
  if (best == row.protocol && (is_biss ? confidence >= 0.9 : confidence < 0.5)) return;
  wrong +=
      fmt::format("{} [{}; sample {} ps]: {} {:.2f} ({}), BiSS C {:.2f} ({})\n", id, capture.note,
                  capture.sample_period.count, identify::name_of(best), guesses.front().confidence,
                  guesses.front().why, confidence, biss == guesses.end() ? "" : biss->why);
}

}  // namespace

Score score(std::uint64_t seed, unsigned others, unsigned biss) {
  Score score;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const Kind& kind = kinds[k];
    score.rows.push_back({.name = kind.name, .protocol = kind.protocol});
    const unsigned count = std::max(1U, (kind.share * others + 500) / 1000);
    for (unsigned i = 0; i < count; ++i) {
      Dice dice(seed << 32U | k << 24U | i);
      const Drawing drawing = kind.draw(dice);
      judge(captured(drawing, dice), fmt::format("{} {}/{}", kind.name, seed, i), score.rows.back(),
            score.wrong);
    }
  }
  score.rows.push_back({.name = biss_name, .protocol = Protocol::biss_c});
  for (unsigned i = 0; i < biss; ++i) {
    Dice dice(seed << 32U | std::uint64_t{255} << 24U | i);
    judge(biss_capture(dice), fmt::format("{} {}/{}", biss_name, seed, i), score.rows.back(),
          score.wrong);
  }
  return score;
}

std::string table_of(const Score& score) {
  std::string text = "| capture of | number | right | taken for |\n|---|---|---|---|\n";
  for (const Row& row : score.rows) {
    std::string others;
    for (std::size_t p = 0; p < identify::protocol_count; ++p) {
      const auto protocol = static_cast<Protocol>(p);
      if (row.counts[p] == 0 || protocol == row.protocol) continue;
      others += fmt::format("{}{} `{}`", others.empty() ? "" : ", ", row.counts[p],
                            identify::name_of(protocol));
    }
    text += fmt::format("| {} | {} | {} `{}` | {} |\n", row.name, row.all, row.right(),
                        identify::name_of(row.protocol), others);
  }
  return text;
}

}  // namespace biss::other_lines
