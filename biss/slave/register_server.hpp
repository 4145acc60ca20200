// The encoder's end of the control communication: registers and commands, a bit a frame.
//
//   RegisterServer server(Registers{...});   // an owner as register_owner.hpp says
//   struct Encoder {                         // the source of a Slave
//     ...
//     bool cds(bool predecessor) { return server.cds(predecessor); }
//     void cdm(bool bit) { server.cdm(bit); }
//   };
//
// Bits and their numbers: biss/control/control_frame.hpp.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"
#include "biss/control/control_header.hpp"
#include "biss/slave/command_answer.hpp"
#include "biss/slave/id_assignment.hpp"
#include "biss/slave/register_owner.hpp"

namespace biss {

/// Answers for one device with `Ids` slaves, each of which takes an ID: slave 0 the lowest. In a
/// BiSS frame the channels of the highest ID come first.
///
/// Whatever the master sends, 14 zeros bring the server back; before the first 14 it is silent.
/// Command 01 it executes itself: an addressed slave that accepts it takes no ID any more, the
/// broadcast takes that back.
template <RegisterOwner Owner, unsigned Ids = 1>
class RegisterServer {
 public:
  constexpr explicit RegisterServer(Owner owner, const RegisterServerOptions& options = {})
      : owner_(owner), options_(options) {}

  /// The CDS bit of the frame under way. Frames that end before CDS do not ask.
  /// \param predecessor what SLI brought, false where the device is not chained
  constexpr bool cds(bool predecessor) {
    if (phase_ == Phase::header && index_ < control_bit::idl_end) {
      return ids_.take(index_, predecessor);
    }
    return predecessor || out_;
  }

  /// The CDM bit that has ended a frame.
  constexpr void cdm(bool bit) {
    out_ = false;
    zeros_ = bit ? 0 : static_cast<std::uint8_t>(zeros_ + 1);
    if (zeros_ >= control_reset_zeros) {
      zeros_ = control_reset_zeros;
      phase_ = Phase::idle;
      return;
    }
    ++index_;
    take(bit);
  }

  /// Whether this slave takes no ID, from the next control frame on.
  constexpr bool control_active(unsigned slave) const { return !ids_.is_silent(slave); }
  /// Waits for a start bit: the last 14 bits were 0.
  constexpr bool idle() const { return phase_ == Phase::idle; }
  constexpr Owner& owner() { return owner_; }
  constexpr const Owner& owner() const { return owner_; }

 private:
  // What the next CDM bit is.
  enum class Phase : std::uint8_t {
    silent,  // nothing until 14 zeros
    idle,
    header,
    read,   // R
    write,  // W
    byte_start,
    byte_out,
    byte_in,
    byte_end,  // P
    command,
  };

  constexpr void take(bool bit) {
    switch (phase_) {
      case Phase::silent:
        break;
      case Phase::idle:  // a zero here is one of 14
        begin();
        break;
      case Phase::header:
        word_ = word_ << 1U | std::uint32_t{bit};
        if (index_ == control_bit::header_end - 1) phase_ = after_header();
        break;
      case Phase::read:
        access_ = bit ? RegisterAccess::read : RegisterAccess::write;
        out_ = bit;
        phase_ = Phase::write;
        break;
      case Phase::write:
        phase_ = answer_access(bit);
        break;
      case Phase::byte_start:
        phase_ = bit ? start_byte() : Phase::silent;
        break;
      case Phase::byte_out:
        shift_out();
        break;
      case Phase::byte_in:
        shift_in(bit);
        break;
      case Phase::byte_end:
        phase_ = end_byte();
        break;
      case Phase::command:
        out_ = command_.take(bit, ids_, owner_);
        if (command_.done()) phase_ = Phase::silent;
        break;
    }
  }

  constexpr void begin() {
    phase_ = Phase::header;
    index_ = control_bit::start;
    word_ = 0;
    bytes_ = 0;
    ids_.begin();
  }

  constexpr Phase after_header() {
    const std::optional<ControlHeader> header = parse_header(word_);
    if (!header) return Phase::silent;
    if (!header->register_access) {
      command_.begin(*header);
      return Phase::command;
    }
    const std::optional<unsigned> slave = ids_.slave_of(header->slave);
    if (!slave) return Phase::silent;
    slave_ = static_cast<std::uint8_t>(*slave);
    address_ = header->address;
    return Phase::read;
  }

  constexpr Phase answer_access(bool w) {
    const bool reading = access_ == RegisterAccess::read;
    const bool understood = w != reading;
    const bool permitted = understood && owner_.permits(slave_, access_, address_);
    // Refused is R = W; without the inversion W comes back as it was.
    out_ = permitted || !options_.w_inversion ? w : reading;
    return permitted ? Phase::byte_start : Phase::silent;
  }

  // S has come.
  constexpr Phase start_byte() {
    if (bytes_ != 0 && busy_ != 0) {
      --busy_;
      return Phase::byte_start;
    }
    std::optional<std::uint8_t> value = 0;
    if (access_ == RegisterAccess::read) {
      value = owner_.read(slave_, address_);
      if (!value) return Phase::byte_start;
    } else if (bytes_ != 0 && !owner_.ready(slave_)) {
      return Phase::byte_start;
    }
    out_ = true;
    bits_ = 0;
    word_ = std::uint32_t{*value} << 4U | byte_crc(*value);
    return access_ == RegisterAccess::read ? Phase::byte_out : Phase::byte_in;
  }

  constexpr void shift_out() {
    out_ = (word_ >> (byte_bits - 1U - bits_) & 1U) != 0;
    if (++bits_ == byte_bits) finish_byte(true);
  }

  constexpr void shift_in(bool bit) {
    out_ = bit;
    word_ = word_ << 1U | std::uint32_t{bit};
    if (++bits_ != byte_bits) return;
    const auto value = static_cast<std::uint8_t>(word_ >> 4U);
    const bool good = byte_crc(value) == (word_ & 0xFU);
    if (good) owner_.write(slave_, address_, value);
    finish_byte(good);
  }

  constexpr void finish_byte(bool good) {
    ++bytes_;
    if (!good) bytes_ = options_.sequence_bytes;  // what follows could land at a wrong address
    phase_ = Phase::byte_end;
  }

  constexpr Phase end_byte() {
    ++address_;
    busy_ = options_.busy_frames;
    const bool more = bytes_ < options_.sequence_bytes && address_ < register_count &&
                      owner_.permits(slave_, access_, address_);
    out_ = !more;
    return more ? Phase::byte_start : Phase::silent;
  }

  static constexpr unsigned byte_bits = 12;  // DATA and CRC

  [[no_unique_address]] Owner owner_;
  RegisterServerOptions options_;
  slave_detail::IdAssignment<Ids> ids_;
  slave_detail::CommandAnswer<Owner, Ids> command_;
  Phase phase_ = Phase::silent;
  std::uint8_t zeros_ = 0;
  std::uint8_t index_ = 0;  // k of the last CDM bit; means nothing behind the header
  bool out_ = false;        // CDS of the next frame
  std::uint32_t word_ = 0;  // bits as they come or go
  std::uint8_t bits_ = 0;   // of the byte under way
  std::uint8_t bytes_ = 0;  // of this access
  std::uint16_t busy_ = 0;
  RegisterAccess access_ = RegisterAccess::read;
  std::uint8_t slave_ = 0;
  std::uint8_t address_ = 0;
};

}  // namespace biss
