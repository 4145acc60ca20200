// The encoder's end of the control communication with a master that sends any bits. No write occurs
// without permission, CDS has no bit that is not due, and 14 zeros end every state. After them
// every register reads as expected.
//
// Input: options of the server and its registers, five bytes; then the actions of the master, one
// or two bytes each: bits 0…2 the kind (enum Op), the other bits the parameters.
#include "biss/control/session.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"
#include "fuzz/control_end.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

constexpr unsigned banks = 2;

/// The protection of a slave's register. `bank` is ignored from 0x40 on. BSEL has its own rules.
RegisterProtection protection_of(unsigned slave, unsigned bank, unsigned address) {
  if (address == reg::bsel) return RegisterProtection::read_write;
  if (address < reg::bsel && bank >= banks) return RegisterProtection::not_available;
  const unsigned part = address < reg::bsel ? bank : banks;
  // Runs of eight, mostly readable and writable.
  const unsigned run = (address / 8U + 5U * part + 3U * slave) % 8U;
  if (run == 0) return RegisterProtection::not_available;
  return run == 1 ? RegisterProtection::read_only : RegisterProtection::read_write;
}

bool permits(unsigned slave, unsigned bank, RegisterAccess access, unsigned address) {
  if (address >= register_count) return false;
  const RegisterProtection protection = protection_of(slave, bank, address);
  return protection == RegisterProtection::read_write ||
         (protection == RegisterProtection::read_only && access == RegisterAccess::read);
}

/// The expected content of one slave's registers, kept separately from them.
struct Mirror {
  unsigned slave = 0;
  bool busy = false;
  bool accepts = false;
  bool accepted = false;  // at the last request
  std::uint32_t cdm = 0;  // the last bits sent, the latest lowest
  std::uint8_t bsel = 0;
  std::array<std::array<std::uint8_t, bank_bytes>, banks + 1> parts{};

  std::uint8_t at(unsigned address) const {
    if (address == reg::bsel) return bsel;
    return parts[address < reg::bsel ? bsel : banks][address % bank_bytes];
  }
};

struct Hooks : NoRegisterHooks {
  Mirror* mirror = nullptr;

  void reading(std::uint8_t bank, std::uint8_t address, std::uint8_t& value) const {
    require(bank == mirror->bsel && value == mirror->at(address));
    require(permits(mirror->slave, bank, RegisterAccess::read, address));
  }
  void written(std::uint8_t bank, std::uint8_t address, std::uint8_t value) const {
    require(permits(mirror->slave, mirror->bsel, RegisterAccess::write, address));
    require((mirror->cdm & 0xFFFU) == (std::uint32_t{value} << 4U | byte_crc(value)));
    if (address == reg::bsel) {
      mirror->bsel = value;
    } else {
      mirror->parts[address < reg::bsel ? bank : banks][address % bank_bytes] = value;
    }
    require(bank == mirror->bsel);
  }
  bool busy() const { return mirror->busy; }
  bool accepts(ControlCommand, bool) const {
    mirror->accepted = mirror->accepts;
    return mirror->accepts;
  }
  void execute(ControlCommand, bool) const {
    require(mirror->accepted);
    mirror->accepted = false;
  }
};

using Registers = BankedRegisters<banks, Hooks>;

struct Setup {
  RegisterServerOptions server{};
  RegisterBusy busy{};
  std::uint8_t predecessor = 0;  // bits it sends beside what the master does
  bool behind_another = false;   // at the end
  std::uint8_t address = 0;      // read and written at the end
  std::uint8_t size = 1;
};

Setup read_setup(ByteSource& bytes) {
  Setup setup;
  const std::uint8_t flags = bytes.next();
  setup.server.w_inversion = (flags & 2U) == 0;
  setup.behind_another = (flags & 4U) != 0;
  setup.server.busy_frames = (flags >> 3U) % 4U;
  setup.size = static_cast<std::uint8_t>(1 + (flags >> 5U));
  const std::uint8_t busy = bytes.next();
  setup.busy = {.read_frames = static_cast<std::uint16_t>(busy % 4U),
                .write_frames = static_cast<std::uint16_t>((busy >> 2U) % 4U)};
  setup.server.sequence_bytes = static_cast<std::uint8_t>((busy & 0x80U) != 0 ? 1 + busy % 8U : 64);
  setup.predecessor = bytes.next();
  setup.address = bytes.next() & 0x7FU;
  return setup;
}

/// A device of `Ids` slaves and its hostile master.
template <unsigned Ids>
class Bench {
 public:
  using Owner = PerSlave<Registers, Ids>;
  using Server = RegisterServer<Owner, Ids>;

  explicit Bench(const Setup& setup) : setup_(setup), server_(powered_up()) {}

  void attack(ByteSource& bytes);
  void check_answers();

 private:
  enum Op : std::uint8_t { raw, zeros, access, command, choice, data, ones, device };

  Server powered_up();
  void frame(bool cdm, bool predecessor, bool asked = true);
  void send(std::uint32_t word, unsigned bits) {
    for (unsigned i = bits; i-- > 0;) frame((word >> i & 1U) != 0, next_predecessor());
  }
  void frame_end(bool cdm) {
    for (Mirror& mirror : mirrors_) mirror.cdm = mirror.cdm << 1U | (cdm ? 1U : 0U);
    server_.cdm(cdm);
  }
  bool next_predecessor() { return (setup_.predecessor >> (frames_ % 8U) & 1U) != 0; }
  void change_device(unsigned how);
  void run(ControlSession& session);
  void check_slave(unsigned slave, unsigned id);

  Setup setup_;
  std::array<Mirror, Ids> mirrors_{};
  Server server_;
  std::optional<OpenServer> predecessor_{};
  Picoseconds now_{};
  std::uint32_t frames_ = 0;
  unsigned zeros_ = 0;
  bool heard_zeros_ = false;  // 14 since power-up
};

template <unsigned Ids>
typename Bench<Ids>::Server Bench<Ids>::powered_up() {
  const auto made = [&](unsigned slave) {
    Mirror& mirror = mirrors_[slave];
    mirror = {.slave = slave};
    Registers registers({.mirror = &mirror}, setup_.busy);
    for (unsigned part = 0; part <= banks; ++part) {
      for (unsigned i = 0; i < bank_bytes; ++i) {
        const auto value = static_cast<std::uint8_t>(17 * slave + 71 * part + 3 * i);
        mirror.parts[part][i] = value;
        const std::array one{value};
        if (part < banks) {
          registers.bank(part).put(i, one, protection_of(slave, part, i));
        } else if (i != 0) {
          registers.put(reg::bsel + i, one, protection_of(slave, 0, reg::bsel + i));
        }
      }
    }
    return registers;
  };
  zeros_ = 0;
  heard_zeros_ = false;
  if constexpr (Ids == 1) {
    return Server(Owner{{made(0)}}, setup_.server);
  } else {
    return Server(Owner{{made(0), made(1), made(2)}}, setup_.server);
  }
}

template <unsigned Ids>
void Bench<Ids>::frame(bool cdm, bool predecessor, bool asked) {
  if (asked) {
    const bool cds = server_.cds(predecessor);
    require(cds || !predecessor);
    if (server_.idle() || !heard_zeros_) require(cds == predecessor);
  }
  frame_end(cdm);
  zeros_ = cdm ? 0 : zeros_ + 1;
  heard_zeros_ = heard_zeros_ || zeros_ >= biss::control_reset_zeros;
  require(server_.idle() == (zeros_ >= control_reset_zeros));
  ++frames_;
}

template <unsigned Ids>
void Bench<Ids>::change_device(unsigned how) {
  if (how == 31) {
    server_ = powered_up();
    return;
  }
  for (Mirror& mirror : mirrors_) {
    mirror.busy = (how & 1U) != 0;
    mirror.accepts = (how & 2U) != 0;
  }
}

template <unsigned Ids>
void Bench<Ids>::attack(ByteSource& bytes) {
  while (!bytes.done()) {
    const std::uint8_t byte = bytes.next();
    const unsigned how = byte >> 3U;
    switch (byte % 8U) {
      case raw:
        for (unsigned i = 0; i <= how >> 3U; ++i) {
          frame((how & 1U) != 0, (how & 2U) != 0, (how & 4U) == 0);
        }
        break;
      case zeros:
      case ones:
        for (unsigned i = 0; i < how; ++i) frame(byte % 8U == ones, next_predecessor());
        break;
      case access: {
        const std::uint16_t header = register_header(how % 8U, bytes.next());
        const unsigned crc = header_crc(header) ^ (how == 31 ? 1U : 0U);
        send(1U << 15U | std::uint32_t{header} << 4U | crc, 16);
        break;
      }
      case command: {
        const auto number = static_cast<ControlCommand>(how % 4U);
        const std::uint16_t header = command_header(bytes.next(), number);
        send(1U << 15U | std::uint32_t{header} << 4U | header_crc(header), 16);
        break;
      }
      case choice:
        send(how % 8U, 3);
        break;
      case data: {
        const std::uint8_t value = bytes.next();
        const unsigned crc = byte_crc(value) ^ (how & 8U);
        send(std::uint32_t{value} << 4U | crc, 12);
        send(how % 4U, 2);  // P, and S of the next one
        break;
      }
      default:
        change_device(how);
    }
  }
}

template <unsigned Ids>
void Bench<Ids>::run(ControlSession& session) {
  run_access(
      session, now_, 1000, [&] { return server_.cds(predecessor_ && predecessor_->cds(false)); },
      [&](bool bit) {
        if (predecessor_) predecessor_->cdm(bit);
        frame_end(bit);
      });
}

template <unsigned Ids>
void Bench<Ids>::check_slave(unsigned slave, unsigned id) {
  Mirror& mirror = mirrors_[slave];
  // The server and the registers before this one may each be busy for 3 frames.
  ControlSession session({.busy_max = microseconds(8 * 50)});
  std::array<std::uint8_t, 8> bytes{};
  session.read(id, setup_.address, std::span(bytes).first(setup_.size));
  if (session.done()) return;  // The range is beyond the last register.
  run(session);
  unsigned due = 0;
  while (due < setup_.size && due < setup_.server.sequence_bytes &&
         permits(slave, mirror.bsel, RegisterAccess::read, setup_.address + due)) {
    ++due;
  }
  require(session.outcome().bytes_done == due);
  for (unsigned i = 0; i < due; ++i) require(bytes[i] == mirror.at(setup_.address + i));
  auto refused = setup_.server.w_inversion ? ControlError::refused : ControlError::busy_too_long;
  if (due != 0) refused = ControlError::next_unavailable;
  require(session.outcome().error == (due == setup_.size ? std::nullopt : std::optional(refused)));
  // A write changes only the addressed slave, and only if writing is permitted.
  const auto before = mirrors_;
  const std::array value{static_cast<std::uint8_t>(~mirror.at(reg::mfr_id))};
  const bool writable = permits(slave, mirror.bsel, RegisterAccess::write, reg::mfr_id);
  session.write(id, reg::mfr_id, value);
  run(session);
  require(session.outcome().error.has_value() == !writable);
  for (unsigned other = 0; other < Ids; ++other) {
    const bool meant = other == slave && writable;
    require(mirrors_[other].at(reg::mfr_id) == (meant ? value[0] : before[other].at(reg::mfr_id)));
  }
}

template <unsigned Ids>
void Bench<Ids>::check_answers() {
  for (Mirror& mirror : mirrors_) mirror.busy = false;
  if (setup_.behind_another) predecessor_.emplace(OpenRegisters{});
  // A slave with inactive control communication takes no ID, so the slaves after it move up.
  unsigned id = predecessor_ ? 1 : 0;
  bool any_silent = false;
  for (unsigned slave = 0; slave < Ids; ++slave) {
    if (server_.control_active(slave)) {
      check_slave(slave, id++);
    } else {
      any_silent = true;
    }
  }
  if (!any_silent) return;
  ControlSession session;
  session.broadcast(ControlCommand::control);
  run(session);
  for (unsigned slave = 0; slave < Ids; ++slave) {
    require(server_.control_active(slave));
    check_slave(slave, (predecessor_ ? 1U : 0U) + slave);
  }
}

template <unsigned Ids>
void run_bench(const Setup& setup, ByteSource& bytes) {
  Bench<Ids> bench(setup);
  bench.attack(bytes);
  bench.check_answers();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  const bool one = size == 0 || (data[0] & 1U) == 0;
  const Setup setup = read_setup(bytes);
  one ? run_bench<1>(setup, bytes) : run_bench<3>(setup, bytes);
  return 0;
}
