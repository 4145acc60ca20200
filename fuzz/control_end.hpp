// The other end of the control communication, with valid behaviour: registers and an encoder of one
// slave, and accesses that must succeed.
#pragma once

#include "biss/control/session.hpp"
#include "biss/slave/register_server.hpp"
#include "fuzz/target.hpp"

namespace biss::fuzz {

/// All 128 registers readable and writable, every command accepted.
struct OpenRegisters {
  std::array<std::uint8_t, register_count> value{};

  bool permits(unsigned slave, RegisterAccess, std::uint8_t address) const {
    require(slave == 0 && address < register_count);
    return true;
  }
  std::optional<std::uint8_t> read(unsigned, std::uint8_t address) const { return value[address]; }
  bool ready(unsigned) const { return true; }
  void write(unsigned, std::uint8_t address, std::uint8_t byte) { value[address] = byte; }
  bool accepts(unsigned, ControlCommand, bool) const { return true; }
  void execute(unsigned, ControlCommand, bool) const {}
};

using OpenServer = RegisterServer<OpenRegisters>;

/// Steps a session until it is done. `frame` returns CDS, then takes CDM. More frames than `most`
/// are a finding.
/// \return the number of frames
template <class Cds, class Cdm>
std::uint32_t run_access(ControlSession& session, Picoseconds& now, std::uint32_t most, Cds cds,
                         Cdm cdm) {
  std::uint32_t frames = 0;
  while (!session.done()) {
    require(frames < most);
    now += microseconds(50);
    const CdsBit heard = cds() ? CdsBit::one : CdsBit::zero;
    cdm(session.step(now, heard));
    ++frames;
  }
  return frames;
}

}  // namespace biss::fuzz
