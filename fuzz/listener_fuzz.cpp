// The listener of the control communication on trains of CDM and CDS bits. An access reported as
// good is good in every bit, the rows keep their contract, and after 14 zeros a good access is
// received completely.
//
// Input: one byte for each run of cycles: bits 0 and 1 the source of CDM (0, 1, a valid master,
// none), bits 2 and 3 the source of CDS (0, 1, an encoder, none), bits 4…6 the number of cycles, as
// a power of two.
#include "decode/control_listener.hpp"
#include "fuzz/control_end.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::decode;

using Bit = std::optional<bool>;

class Train {
 public:
  Train() : server_(OpenRegisters{}), listener_([this](const SeenAccess& row) { check(row); }) {}

  void attack(ByteSource& bytes) {
    while (!bytes.done()) {
      const std::uint8_t byte = bytes.next();
      for (unsigned i = 0; i < 1U << (byte >> 4U) % 8U; ++i) cycle(byte % 4U, byte >> 2U & 3U);
    }
  }
  void check_good_access() {
    for (unsigned i = 0; i < control_reset_zeros + 1; ++i) cycle(0, 0);
    session_.cancel();
    if (!server_.control_active(0)) {
      session_.broadcast(ControlCommand::control);
      while (!session_.done()) cycle(2, 2);
    }
    const std::uint64_t before = good_;
    session_.write(0, 0x33, written_);
    while (!session_.done()) cycle(2, 2);
    require(!session_.outcome().error);
    session_.read(0, 0x33, read_);
    while (!session_.done()) cycle(2, 2);
    require(!session_.outcome().error && read_ == written_);
    cycle(0, 2);
    listener_.finish();
    require(good_ == before + written_.size() + read_.size());
  }

 private:
  struct Cycle {
    Bit cds;
    Bit cdm;
    bool fresh;  // 14 zeros were sent before
  };

  static Bit choose(unsigned who, bool good) {
    if (who == 3) return std::nullopt;
    return who == 2 ? good : who == 1;
  }

  void cycle(unsigned cdm_by, unsigned cds_by) {
    now_ += microseconds(50);
    if (session_.done() && cdm_by == 2) next_access();
    const Bit cds = choose(cds_by, server_.cds(false));
    const auto heard = !cds ? CdsBit::missing : *cds ? CdsBit::one : CdsBit::zero;
    const Bit cdm = choose(cdm_by, session_.step(now_, heard));
    server_.cdm(cdm.value_or(false));
    cycles_.push_back({cds, cdm, zeros_ >= control_reset_zeros});
    zeros_ = cdm == false ? zeros_ + 1 : 0;
    listener_.push(cycles_.size() - 1, now_, cds, cdm);
  }

  void next_access() {
    ++accesses_;
    const auto address = static_cast<unsigned>(accesses_ * 29 % 120);
    if (accesses_ % 3 == 0) return session_.command(1, ControlCommand::user);
    if (accesses_ % 3 == 1) return session_.read(0, address, read_);
    session_.write(0, address, written_);
  }

  // `size` bits from a cycle on; none of them is missing.
  std::uint32_t bits(std::size_t from, unsigned size, Bit Cycle::*side) const {
    std::uint32_t word = 0;
    for (std::size_t i = from; i < from + size; ++i) {
      require(i < cycles_.size() && (cycles_[i].*side).has_value());
      word = word << 1U | (*(cycles_[i].*side) ? 1U : 0U);
    }
    return word;
  }

  void check(const SeenAccess& row) {
    require(row.cycle < cycles_.size() && row.cycle >= last_);
    require(!name_of(row.kind).empty() && !name_of(row.outcome).empty());
    require(row.id < control_max_slaves && row.address < register_count);
    require(row.busy.count >= 0 && row.cycles <= cycles_.size() - row.cycle + 1);
    last_ = row.cycle;
    if (row.outcome != AccessOutcome::ok) return;
    ++good_;
    require(row.kind != SeenAccess::Kind::unknown && row.header_sent);
    require(row.data.has_value() == (row.kind != SeenAccess::Kind::command));
    // The further bytes of a sequence have no header of their own.
    if (!cycles_[row.cycle].fresh) return;
    require(cycles_[row.cycle].cdm == true);
    const auto header = parse_header(bits(row.cycle + 1, 15, &Cycle::cdm));
    require(header && header->register_access == (row.kind != SeenAccess::Kind::command));
    if (row.kind == SeenAccess::Kind::command) {
      require(header->slaves == row.slaves && header->command == row.command);
      return;
    }
    require(header->slave == row.id && header->address == row.address);
    require(row.slaves_present != 0 && (row.slaves_present & (row.slaves_present + 1U)) == 0);
    // The CDS bit of a number comes one cycle after the CDM bit.
    const std::size_t first = row.cycle + control_bit::byte_start + 1 + row.busy_cycles;
    const std::uint32_t good = std::uint32_t{*row.data} << 4U | byte_crc(*row.data);
    require(bits(first + 1, 12, &Cycle::cds) == good);
    if (row.kind == SeenAccess::Kind::write) require(bits(first, 12, &Cycle::cdm) == good);
  }

  std::vector<Cycle> cycles_{};
  ControlSession session_;
  OpenServer server_;
  Picoseconds now_{};
  std::array<std::uint8_t, 3> read_{};
  std::array<std::uint8_t, 3> written_{0x5A, 0xFF, 0x00};
  std::uint64_t good_ = 0;
  std::uint64_t last_ = 0;
  unsigned accesses_ = 0;
  unsigned zeros_ = 0;
  ControlListener listener_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  Train train;
  train.attack(bytes);
  train.check_good_access();
  return 0;
}
