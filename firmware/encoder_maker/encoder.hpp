// An encoder's side of the line in firmware, stepped by two interrupts:
//
//   edge of MA                      timer has reached the alarm         main loop
//   ----------------------------    -------------------------------     ---------------------------
//   encoder.step()                  encoder.step()                      encoder.do_ordered_work()
//
// Give both interrupts the same priority, so that neither interrupts the other. The time from an
// edge of MA to the edge of SLO is the cost of one step (docs/firmware.md, "slave, one bit of
// data"). That time limits the clock rate. With a hardware shift register, load the register with
// the same bits.
#pragma once

#include <concepts>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"
#include "firmware/encoder_maker/device.hpp"

namespace encoder_maker {

/// The board: two pins, a free-running clock with one alarm, the sensor, and non-volatile memory.
template <class T>
concept Board = requires(T& board, biss::Picoseconds at, std::uint32_t count, bool level) {
  { board.now() } -> std::same_as<biss::Picoseconds>;
  { board.ma() } -> std::same_as<bool>;
  board.drive_slo(level);
  /// Sets the only alarm. A later call moves it, biss::never cancels it.
  board.set_alarm(at);
  /// The sensor's count at that time, in `position_bits` bits.
  { board.sensor(at) } -> std::same_as<std::uint32_t>;
  /// Degrees Celsius.
  { board.temperature() } -> std::same_as<int>;
  /// Masks the interrupts that call step(), and is a barrier for the compiler.
  board.mask_interrupts(level);
  /// Stores the value permanently; may take milliseconds.
  board.store_offset(count);
};

/// The source of the slave's values while it is stepped.
template <Board Hardware>
struct Source {
  Hardware* board;
  std::uint32_t offset;
  biss::RegisterServer<Registers> server;

  constexpr biss::BasicFrame<1> sample(biss::Picoseconds moment) {
    biss::BasicFrame<1> frame;
    frame.channel_list[0].position =
        (board->sensor(moment) + offset) & biss::low_mask(position_bits);
    return frame;
  }
  constexpr bool cds(bool predecessor) { return server.cds(predecessor); }
  constexpr void cdm(bool bit) { server.cdm(bit); }
};

template <Board Hardware>
class Encoder {
 public:
  /// \param board outlives the encoder \param offset what store_offset() kept, 0 from the factory
  constexpr Encoder(Hardware& board, std::uint32_t serial_number, std::uint32_t offset)
      : board_(board),
        slave_(
            biss::FixedCodec<format>{}, timing,
            Source<Hardware>{&board, offset,
                             biss::RegisterServer<Registers>(factory_registers(serial_number))}) {}

  /// Call it in the interrupts: at an edge of MA, and at the alarm.
  constexpr void step() {
    const biss::StepOutput out = slave_.step(board_.now(), board_.ma(), false);
    board_.drive_slo(out.level);
    board_.set_alarm(out.deadline);
    slave_.set_channels_active(hooks().channels_active);
  }

  /// Call it in the main loop, at any interval; a preset waits for it.
  constexpr void do_ordered_work() {
    const auto temperature = static_cast<std::uint8_t>(board_.temperature() + 40);
    board_.mask_interrupts(true);
    hooks().temperature = temperature;
    const bool preset = hooks().preset_ordered;
    std::uint32_t wanted = 0;
    for (unsigned i = 0; i < 3; ++i) wanted = wanted << 8U | registers().value(address::preset + i);
    board_.mask_interrupts(false);
    if (!preset) return;

    const auto mask = static_cast<std::uint32_t>(biss::low_mask(position_bits));
    const std::uint32_t offset = (wanted - board_.sensor(board_.now())) & mask;
    board_.store_offset(offset);  // the slow part; meanwhile the master receives "busy"
    board_.mask_interrupts(true);
    slave_.source().offset = offset;
    hooks().command_byte = 0;
    hooks().preset_ordered = false;
    board_.mask_interrupts(false);
  }

  constexpr const auto& slave() const { return slave_; }

 private:
  // Samples the position at LAT, is ready immediately, and has a timeout of 20 µs.
  static constexpr biss::SlaveTiming timing{
      .timeout = {biss::TimeoutRule::fixed, biss::microseconds(20)}};

  constexpr Registers& registers() { return slave_.source().server.owner(); }
  constexpr Hooks& hooks() { return registers().hooks(); }

  Hardware& board_;
  biss::Slave<biss::FixedCodec<format>, Source<Hardware>, 0> slave_;
};

}  // namespace encoder_maker
