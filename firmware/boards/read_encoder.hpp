// The program of the examples: starts an encoder that it does not know, reads positions and registers
// at the same time, and writes the results to the serial port. All boards run it unchanged.
//
// The encoder: one channel, with registers and a profile or an EDS. firmware/encoder_maker is one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/units.hpp"
#include "biss/control/register_map.hpp"
#include "biss/control/session.hpp"
#include "firmware/boards/cortex_m.hpp"
#include "firmware/boards/encoder_start.hpp"
#include "firmware/platform/console.hpp"

namespace boards {

using firmware::print;

/// From one request to the next: the transfer, the timeout, and some time for the interrupts.
inline constexpr biss::Picoseconds cycle_time = biss::microseconds(100);
/// A drive trips after a few cycles; this program only reads.
inline constexpr biss::AxisSetup axis_setup{
    .cycle = cycle_time, .max_step = 1'000, .trip_after = 5'000};
/// 20 m of cable at most.
inline constexpr biss::LineDelayRange line_delay{.max = biss::nanoseconds(500)};
/// The longest transfer.
inline constexpr std::size_t max_bytes = 64;

/// `Board` has `clocks_per_microsecond`, and is a StartPort.
template <class Board>
class ReadEncoder {
 public:
  constexpr explicit ReadEncoder(Board& board) : start_(board, axis_setup, line_delay) {}

  // The two interrupts.
  void cycle() {
    ++cycles_;
    start_.request(now_ += cycle_time);
  }
  void transfer_ended(bool good) {
    ++transfers_;
    start_.transfer_ended(good);
    if (Link* link = start_.link()) {
      cycle_ = {link->axis().number(), link->axis().position(), link->session().done()};
    }
  }

  /// \return 0: everything was read
  int run() {
    start_cycle_timer(static_cast<std::uint32_t>(cycle_time.count / 1'000'000) *
                      Board::clocks_per_microsecond);
    if (!start()) return 1;
    const bool good = read_registers();
    write_counts();
    return good ? 0 : 1;
  }

 private:
  using Link = typename EncoderStart<Board, max_bytes>::Link;
  static constexpr unsigned most_causes = 5;
  static constexpr std::uint32_t written_every = 50;

  // The end of a cycle; its number counts from 1.
  struct Cycle {
    std::uint32_t number = 0;
    biss::AxisPosition axis{};
    bool done = false;
  };

  // Prints each cause until there is a link.
  bool start() {
    std::uint32_t ready = 0;
    std::uint32_t asked = 0;
    for (unsigned causes = 0; start_.link() == nullptr; wait_for_interrupt()) {
      std::optional<StartFault> fault;
      {
        const InterruptMask mask;
        fault = start_.advance();
        if (start_.link() != nullptr) {
          written_ = cycle_.number = first_ = start_.link()->axis().number();
          ready = cycles_;
          asked = transfers_ - first_;
        }
      }
      if (!fault) continue;
      write_fault(*fault);
      if (++causes == most_causes) return false;
    }
    print("ready in cycle ", ready, ": transfer ", asked + first_, ", checked from ", asked, "\n");
    const biss::ChannelFormat& channel = start_.reader().codec().format().channel_list[0];
    print("serial number ", std::uint32_t{start_.record().serial}, ", position bits ",
          channel.position_bits(), ", data bits ", channel.data_bits, ", CRC bits ",
          channel.crc.width_bits, ", bytes ", start_.reader().bytes(), "\n");
    return true;
  }

  static void write_fault(const StartFault& fault) {
    print("start: ", name_of(fault.cause));
    if (fault.record) print(" ", name_of(*fault.record));
    if (fault.axis) print(" ", name_of(*fault.axis));
    if (fault.configure) print(" ", name_of(fault.configure->cause));
    if (fault.control) print(" ", name_of(*fault.control));
    print("\n");
  }

  // Reads registers while it prints positions.
  bool read_registers() {
    std::array<std::uint8_t, 48> bytes{};
    const std::span all(bytes);
    if (!read(biss::reg::dev_id, all.first(8)) || !read(biss::reg::bsel, all.subspan(8, 8)) ||
        !read(biss::reg::bank, all.subspan(16))) {
      return false;
    }
    print("registers");
    for (const std::uint8_t byte : bytes) print(" ", firmware::Hex{byte});
    print("\n");
    return true;
  }

  bool read(std::uint8_t address, std::span<std::uint8_t> to) {
    {
      const InterruptMask mask;
      start_.link()->session().read(0, address, to);
      cycle_.done = false;
    }
    while (next_cycle()) {
    }
    const auto& error = start_.link()->session().outcome().error;
    if (error) print("access failed: ", name_of(*error), "\n");
    return !error;
  }

  // Waits for the end of the next cycle and prints its position or its cause. False: the access has
  // ended.
  bool next_cycle() {
    Cycle each;
    for (;; wait_for_interrupt()) {
      const InterruptMask mask;
      each = cycle_;
      if (each.number != written_) break;
    }
    written_ = each.number;
    const std::uint32_t cycle = each.number - first_;
    if (each.axis.cause != biss::AxisCause::ok) {
      print("cycle ", cycle, " ", name_of(each.axis.cause), "\n");
    } else if (cycle >= next_position_) {
      next_position_ = (cycle / written_every + 1) * written_every;
      print("cycle ", cycle, " position ", static_cast<std::uint64_t>(each.axis.position), "\n");
    }
    return !each.done;
  }

  // Also counts the frames that were only checked.
  void write_counts() {
    biss::CauseCounts<biss::AxisCause, 0> counts;
    {
      const InterruptMask mask;
      counts = start_.link()->axis().axis().counts();
      written_ = start_.link()->axis().number();
    }
    print("cycles ", written_);
    for (std::size_t i = 0; i < biss::axis_cause_count; ++i) {
      const auto cause = static_cast<biss::AxisCause>(i);
      if (counts[cause] != 0) print(", ", name_of(cause), " ", counts[cause]);
    }
    print("\n");
  }

  EncoderStart<Board, max_bytes> start_;
  biss::Picoseconds now_{};
  Cycle cycle_{};
  std::uint32_t cycles_ = 0;
  std::uint32_t transfers_ = 0;
  // Frames that were only checked, before there was a link.
  std::uint32_t first_ = 0;
  std::uint32_t written_ = 0;
  std::uint32_t next_position_ = 0;
};

}  // namespace boards
