// The program of the examples: reads positions, registers and the electronic data sheet of an
// encoder, and writes the results to the serial port. All boards run it unchanged.
//
// The encoder: 24 bits, with registers and an EDS with profile BP3. firmware/encoder_maker is one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/axis/encoder_link.hpp"
#include "biss/base/units.hpp"
#include "biss/control/register_map.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/image.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"
#include "firmware/boards/cortex_m.hpp"
#include "firmware/platform/console.hpp"

namespace boards {

using firmware::print;

// ---- The encoder, from its data sheet

inline constexpr biss::FrameFormat format = biss::frame_format("pos24,nE,nW,crc6");
inline constexpr biss::DeviceTiming timing{
    .clock_max = biss::megahertz(5),
    .ack_max = biss::microseconds(2),
    .timeout = {biss::TimeoutRule::fixed, biss::microseconds(20)}};

/// The setup of a port with this clock, and 20 m of cable at most.
constexpr biss::SpiSetup spi_setup(biss::Picoseconds period) {
  return {.period = period, .line_delay = {.max = biss::nanoseconds(500)}};
}

template <class Board>
inline constexpr biss::SpiReader reader_of{biss::FixedCodec<format>{}, spi_setup(Board::ma_period),
                                           timing};

/// From one request to the next: the transfer, the timeout, and some time for the interrupts.
inline constexpr biss::Picoseconds cycle_time = biss::microseconds(50);
/// A drive trips after a few cycles; this program only reads.
template <class Board>
inline constexpr biss::AxisSetup axis_setup{
    .cycle = cycle_time,
    .to_sampling = biss::sampling_delay(spi_setup(Board::ma_period), timing),
    .max_step = 1'000,
    .trip_after = 5'000};
/// A damaged frame ends an access; it is then continued.
inline constexpr biss::ControlOptions control_options{.retries = 3};

inline void print_bytes(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) firmware::print(" ", firmware::Hex{byte});
  firmware::write("\n");
}

// ---- The program

/// `Board` has `ma_period`, `clocks_per_microsecond`, and is an EncoderPort.
template <class Board>
class ReadEncoder {
 public:
  static_assert(Board::ma_period >= biss::period_of(timing.clock_max));
  static constexpr const auto& reader = reader_of<Board>;
  static_assert(cycle_time >= std::int64_t{reader.bytes() * 8U} * Board::ma_period +
                                  timing.timeout.time + biss::microseconds(5));

  constexpr explicit ReadEncoder(Board& board)
      : link_(board, reader, axis_setup<Board>, control_options) {}

  // The two interrupts.
  void cycle() { link_.request(now_ += cycle_time); }
  void transfer_complete() {
    link_.transfer_complete();
    ended();
  }
  void transfer_failed() {
    link_.transfer_failed();
    ended();
  }

  /// \return 0: everything was read
  int run() {
    start_cycle_timer(static_cast<std::uint32_t>(cycle_time.count / 1'000'000) *
                      Board::clocks_per_microsecond);
    read_positions();
    const bool good = read_identity() && read_data_sheet();
    write_counts();
    return good ? 0 : 1;
  }

 private:
  static constexpr std::uint32_t first_cycles = 200;
  static constexpr std::uint32_t written_every = 20;

  // The result of a cycle; its number counts from 1.
  struct Cycle {
    std::uint32_t number = 0;
    biss::AxisPosition axis{};
  };

  void ended() { cycle_ = {link_.axis().number(), link_.axis().position()}; }

  Cycle next_cycle(std::uint32_t before) {
    for (;; wait_for_interrupt()) {
      const InterruptMask mask;
      if (cycle_.number != before) return cycle_;
    }
  }

  void read_positions() {
    std::uint32_t next_written = 0;
    for (Cycle each = next_cycle(0); each.number <= first_cycles; each = next_cycle(each.number)) {
      const auto& [cycle, axis] = each;
      if (axis.cause != biss::AxisCause::ok) {
        print("cycle ", cycle, " ", name_of(axis.cause), "\n");
      } else if (cycle >= next_written) {
        next_written = (cycle / written_every + 1) * written_every;
        print("cycle ", cycle, " position ", static_cast<std::uint64_t>(axis.position), "\n");
      }
    }
  }

  // Begins an access and waits for its end. The interrupts do the work, one bit in each cycle.
  template <class Begin>
  bool access(const Begin& begin) {
    for (bool begun = false;; wait_for_interrupt()) {
      const InterruptMask mask;
      if (!begun) begin(link_.session());
      begun = true;
      if (link_.session().done()) break;
    }
    const auto& error = link_.session().outcome().error;
    if (!error) return true;
    print("access failed: ", name_of(*error), "\n");
    return false;
  }

  bool read(std::uint8_t address, std::span<std::uint8_t> to) {
    return access([&](biss::ControlSession& session) { session.read(0, address, to); });
  }

  bool write(std::uint8_t address, std::uint8_t value) {
    const std::array<std::uint8_t, 1> bytes{value};
    return access([&](biss::ControlSession& session) { session.write(0, address, bytes); });
  }

  bool read_bank(std::uint8_t number, biss::EdsBank& bank) {
    if (!write(biss::reg::bsel, number) || !read(0, bank)) return false;
    print("bank ", number);
    print_bytes(bank);
    if (bank[biss::eds_checksum_address] == biss::eds_checksum(bank)) return true;
    print("wrong checksum\n");
    return false;
  }

  bool read_identity() {
    std::array<std::uint8_t, 8> bytes{};
    if (!read(biss::reg::dev_id, bytes)) return false;
    print("registers 0x78");
    print_bytes(bytes);
    if (!read(biss::reg::bsel, bytes)) return false;
    print("registers 0x40");
    print_bytes(bytes);
    registers_ = biss::device_registers(bytes);
    if (registers_.serial) print("serial number ", *registers_.serial);
    print("\n");
    return biss::eds_presence(registers_.eds_bank) == biss::EdsPresence::present;
  }

  // The bank that was selected before is selected again, also after an error.
  bool read_data_sheet() {
    const bool good = read_banks();
    return write(biss::reg::bsel, registers_.bsel) && good;
  }

  bool read_banks() {
    if (!read_bank(registers_.eds_bank, common_)) return false;
    const biss::CommonPart common = biss::parse_common_part(common_);
    if (!read_bank(common.channels[0].bank, profile_)) return false;
    biss::EdsImage image{.common = &common_, .eds_bank = registers_.eds_bank};
    image.profiles[0] = &profile_;
    image.identifiers[0] = registers_.profile;
    // A format from a data sheet with a contradiction may be wrong.
    bool contradiction = false;
    biss::check_eds(image, [&](const biss::EdsFinding& finding) {
      contradiction = contradiction || biss::contradicts(finding);
      print(finding.symbol, ": ", text_of(finding.problem), "\n");
    });
    if (contradiction) return false;
    const auto device = biss::describe_device(image, {}, [](const biss::EdsRemark&) {});
    if (!device.ok()) {
      print(text_of(device.error().cause), "\n");
      return false;
    }
    const biss::ChannelFormat& channel = device->format.channel_list[0];
    print("data sheet: position bits ", channel.position_bits(), ", data bits ", channel.data_bits,
          ", CRC bits ", channel.crc.width_bits, ", clock at most ", device->timing.clock_max.count,
          " Hz\n");
    const bool same = device->format.channel_count == 1 && channel.data_bits == 26 &&
                      channel.crc == format.channel_list[0].crc;
    print(same ? "the format is the one in use\n" : "the format is another one\n");
    return same;
  }

  void write_counts() {
    print("cycles ", link_.axis().number());
    for (std::size_t i = 0; i < biss::axis_cause_count; ++i) {
      const auto cause = static_cast<biss::AxisCause>(i);
      const InterruptMask mask;
      const std::uint32_t count = link_.axis().axis().counts()[cause];
      if (count != 0) print(", ", name_of(cause), " ", count);
    }
    print("\n");
  }

  biss::EncoderLink<Board, std::remove_cvref_t<decltype(reader)>, reader.bytes()> link_;
  biss::Picoseconds now_{};
  Cycle cycle_{};
  biss::DeviceRegisters registers_{};
  biss::EdsBank common_{};
  biss::EdsBank profile_{};
};

}  // namespace boards
