// The encoder's end of the control communication: registers and commands, one bit per frame.
//
//   RegisterServer server(Registers{});  // a RegisterOwner
//   struct Encoder {                     // the source of a Slave
//     bool cds(bool predecessor) { return server.cds(predecessor); }
//     void cdm(bool bit) { server.cdm(bit); }
//   };
//
// Bits and their numbers: biss/control/control_frame.hpp.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"

namespace biss {

// ---- The owner of the registers

/// The owner of a register server:
///
///   struct Registers {
///     bool permits(unsigned slave, RegisterAccess access, std::uint8_t address);
///     std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address);
///     bool ready(unsigned slave);
///     void write(unsigned slave, std::uint8_t address, std::uint8_t value);
///     bool accepts(unsigned slave, ControlCommand command, bool broadcast);
///     void execute(unsigned slave, ControlCommand command, bool broadcast);
///   };
///
/// All are called from the server's cdm(), which a Slave calls when its timeout is over. The answer
/// is sent with the next frame, so they must be short. `slave` counts within the device.
///
/// * `permits`: whether this address may be accessed; called at R and W for the first address, and
///   for each further one when the byte before it is done (the answer is P). False: refused; the
///   protocol has one answer for protected and absent.
/// * `read`: the byte to send; empty: busy; called again with the next frame, for as long as the
///   master waits (20 ms by D2).
/// * `ready`: whether the next byte of a sequential write may come; called again with the next
///   frame. The first byte cannot be delayed and `ready` is not called for it: a device that is
///   still busy with an earlier write stores the byte, or does not permit the access.
/// * `write`: takes a byte with a good CRC.
/// * `accepts`: whether it would execute the command; called once for each addressed slave, and at
///   a broadcast once for each slave of the device. `execute` follows if the master requests it.
template <class Owner>
concept RegisterOwner = requires(Owner owner, unsigned slave, std::uint8_t byte) {
  { owner.permits(slave, RegisterAccess::read, byte) } -> std::same_as<bool>;
  { owner.read(slave, byte) } -> std::same_as<std::optional<std::uint8_t>>;
  { owner.ready(slave) } -> std::same_as<bool>;
  owner.write(slave, byte, byte);
  { owner.accepts(slave, ControlCommand::channels, true) } -> std::same_as<bool>;
  owner.execute(slave, ControlCommand::channels, true);
};

/// Points in which the register servers of devices differ.
struct RegisterServerOptions {
  /// R = W means refused (D2). Old devices repeat W as received and never send the start bit.
  bool w_inversion = true;
  /// S of every byte but the first comes this many frames later than it could (an iC-MHM: 1; AN22).
  std::uint16_t busy_frames = 0;
  /// P = 1 after this many bytes of one access (D2: up to 64).
  std::uint8_t sequence_bytes = sequential_max_bytes;
};

}  // namespace biss

namespace biss::slave_detail {

// ---- The IDs of a device in this control frame: bits IDL0 … IDL8 on CDS

/// The IDs of one device. A slave without an ID that sees 0 at IDL index k takes ID k and makes it
/// 1; one that sees 1 waits. IDs are assigned again in every control frame (D2).
template <unsigned Ids>
class IdAssignment {
  static_assert(Ids >= 1 && Ids <= control_max_slaves);

 public:
  constexpr void begin() {
    slave_of_.fill(none);
    next_ = 0;
    skip_silent();
  }

  /// The bit to send at this index, 0 … 8. \param predecessor the bit that the predecessor sent at
  /// this index
  constexpr bool take(unsigned index, bool predecessor) {
    if (predecessor) return true;
    if (index >= control_max_slaves) return next_ < Ids;  // IDL8: more slaves follow
    if (slave_of_[index] != none) return true;
    if (next_ == Ids) return false;
    slave_of_[index] = next_++;
    skip_silent();
    return true;
  }

  /// The device's slave with this ID.
  constexpr std::optional<unsigned> slave_of(unsigned id) const {
    if (slave_of_[id] == none) return std::nullopt;
    return slave_of_[id];
  }

  /// A silent slave takes no ID, from the next control frame on.
  constexpr void silence(unsigned slave) {
    silent_ = static_cast<std::uint8_t>(silent_ | 1U << slave);
  }
  constexpr void admit_all() { silent_ = 0; }
  constexpr bool is_silent(unsigned slave) const { return (silent_ >> slave & 1U) != 0; }

 private:
  static constexpr std::uint8_t none = 0xFF;

  constexpr void skip_silent() {
    while (next_ < Ids && is_silent(next_)) ++next_;
  }

  std::array<std::uint8_t, control_max_slaves> slave_of_{};
  std::uint8_t next_ = 0;  // the slave that takes the next ID
  std::uint8_t silent_ = 0;
};

// ---- A command's bits after its header: IDA and EX, or only EX for a broadcast

template <RegisterOwner Owner, unsigned Ids>
class CommandAnswer {
 public:
  constexpr void begin(const ControlHeader& header) {
    command_ = header.command;
    slaves_ = header.slaves;
    accepted_ = 0;
    index_ = control_bit::header_end;
    done_ = false;
  }

  /// Takes the next CDM bit. \return the CDS bit with its index
  constexpr bool take(bool bit, IdAssignment<Ids>& ids, Owner& owner) {
    const unsigned index = index_++;
    if (index == (slaves_ == 0 ? control_bit::ex_broadcast : control_bit::ex_addressed)) {
      done_ = true;
      if (bit) slaves_ == 0 ? execute_by_all(ids, owner) : execute(ids, owner);
      return false;
    }
    done_ = bit != (index == control_bit::header_end);  // S, then zeros
    return !done_ && slaves_ != 0 && answer(index - control_bit::ida, ids, owner);
  }

  /// Executed, dropped or aborted.
  constexpr bool done() const { return done_; }

 private:
  constexpr bool answer(unsigned id, const IdAssignment<Ids>& ids, Owner& owner) {
    const std::optional<unsigned> slave = ids.slave_of(id);
    if (!slave || (slaves_ >> id & 1U) == 0) return false;
    if (!owner.accepts(*slave, command_, false)) return false;
    accepted_ = static_cast<std::uint8_t>(accepted_ | 1U << *slave);
    return true;
  }

  constexpr void execute(IdAssignment<Ids>& ids, Owner& owner) {
    for (unsigned slave = 0; slave < Ids; ++slave) {
      if ((accepted_ >> slave & 1U) == 0) continue;
      if (command_ == ControlCommand::control) ids.silence(slave);
      owner.execute(slave, command_, false);
    }
  }

  constexpr void execute_by_all(IdAssignment<Ids>& ids, Owner& owner) {
    if (command_ == ControlCommand::control) ids.admit_all();
    for (unsigned slave = 0; slave < Ids; ++slave) {
      if (owner.accepts(slave, command_, true)) owner.execute(slave, command_, true);
    }
  }

  ControlCommand command_ = ControlCommand::channels;
  std::uint8_t slaves_ = 0;    // bit k: ID k; 0: all
  std::uint8_t accepted_ = 0;  // bit k: this device's slave k
  std::uint8_t index_ = 0;
  bool done_ = true;
};

}  // namespace biss::slave_detail

namespace biss {

/// Answers for one device with `Ids` slaves, each of which takes an ID: slave 0 the lowest. In a
/// BiSS frame the channels of the highest ID come first.
///
/// 14 zeros reset the server at any time; before the first 14 it sends only zeros. It executes
/// command 01 itself: an addressed slave that accepts it no longer takes an ID, and the broadcast
/// reverses that.
template <RegisterOwner Owner, unsigned Ids = 1>
class RegisterServer {
 public:
  constexpr explicit RegisterServer(Owner owner, const RegisterServerOptions& chosen = {})
      : owner_(owner), options_(chosen) {}

  /// The CDS bit of the current frame; not called for a frame that ends before CDS.
  /// \param predecessor CDS from SLI; false if the device is not chained
  constexpr bool cds(bool predecessor) {
    if (phase_ == Phase::header && index_ < control_bit::idl_end) {
      return ids_.take(index_, predecessor);
    }
    return predecessor || out_;
  }

  /// Takes the CDM bit that ended a frame.
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
  // The meaning of the next CDM bit.
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
    // Refused is R = W; without the inversion, W is repeated.
    out_ = permitted || !options_.w_inversion ? w : reading;
    return permitted ? Phase::byte_start : Phase::silent;
  }

  // S was received.
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
    if (!good) bytes_ = options_.sequence_bytes;  // the next bytes could get wrong addresses
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
  std::uint8_t index_ = 0;  // k of the last CDM bit; undefined after the header
  bool out_ = false;        // CDS of the next frame
  std::uint32_t word_ = 0;  // bits received or to send
  std::uint8_t bits_ = 0;   // of the current byte
  std::uint8_t bytes_ = 0;  // of this access
  std::uint16_t busy_ = 0;
  RegisterAccess access_ = RegisterAccess::read;
  std::uint8_t slave_ = 0;
  std::uint8_t address_ = 0;
};

}  // namespace biss
