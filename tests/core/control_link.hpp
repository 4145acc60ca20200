// A control session and register servers on one line, stepped by BiSS frames, with faults on the
// line.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "biss/control/session.hpp"
#include "biss/slave/register_server.hpp"
#include "tests/core/control_bench.hpp"

namespace biss::test {

inline constexpr std::uint32_t never_frame = 0xFFFF'FFFF;

/// The fault and its frame, counted from the call of damage(); 0 is the next frame.
struct Damage {
  std::uint32_t flip_cdm = never_frame;  ///< the slaves receive the inverted bit
  std::uint32_t flip_cds = never_frame;  ///< the master receives the inverted bit
  std::uint32_t reset = never_frame;     ///< all devices are as after power-up, before this frame
  std::uint32_t cut = never_frame;       ///< first frame that neither end receives
  std::uint32_t cut_frames = 0;          ///< number of frames of the cut
  bool deaf = false;                     ///< the cut affects SLO only: the slaves still receive
};

/// A chain of `Count` devices of one slave each, and their master.
template <std::size_t Count>
class ControlLink {
 public:
  using Server = RegisterServer<TestOwner>;

  explicit ControlLink(const RegisterServerOptions& server_options = {},
                       const ControlOptions& options = {})
      : session(options),
        options_(server_options),
        servers_(make(std::make_index_sequence<Count>{})) {}
  ControlLink(const ControlLink&) = delete;
  ControlLink& operator=(const ControlLink&) = delete;

  void damage(const Damage& damage) {
    damage_ = damage;
    frame_ = 0;
  }

  /// One BiSS frame.
  void step() {
    if (frame_ == damage_.reset) servers_ = make(std::make_index_sequence<Count>{});
    const bool cut = frame_ >= damage_.cut && frame_ - damage_.cut < damage_.cut_frames;
    now += cycle;
    const bool arrives = !cut || damage_.deaf;
    bool cds = false;
    if (arrives) {
      for (Server& server : servers_) cds = server.cds(cds);
    }
    CdsBit heard = cds != (frame_ == damage_.flip_cds) ? CdsBit::one : CdsBit::zero;
    if (cut) heard = CdsBit::missing;
    bool cdm = session.cdm_ahead();
    if (ahead) {
      session.take_cds(now, heard);
    } else {
      cdm = session.step(now, heard);
    }
    cdm = cdm != (frame_ == damage_.flip_cdm);
    if (arrives) {
      for (Server& server : servers_) server.cdm(cdm);
    }
    ++frame_;
  }

  /// Runs until the access has ended. False: it does not end.
  bool run(std::uint32_t most = 3000) {
    for (std::uint32_t i = 0; i < most && !session.done(); ++i) step();
    return session.done();
  }

  bool read(unsigned slave, unsigned address, std::span<std::uint8_t> to) {
    session.read(slave, address, to);
    return run() && !session.outcome().error;
  }
  bool write(unsigned slave, unsigned address, std::span<const std::uint8_t> from) {
    session.write(slave, address, from);
    return run() && !session.outcome().error;
  }
  /// A frame of another master than the session.
  void noise(bool cdm) { control_frame(servers_, cdm); }

  ControlError error() const { return session.outcome().error.value_or(no_error); }

  /// Means "ended without error" in comparisons of outcomes.
  static constexpr auto no_error = static_cast<ControlError>(255);
  static constexpr Picoseconds cycle = microseconds(100);

  std::array<TestRegisters, Count> registers{};
  ControlSession session;
  Picoseconds now{};
  /// The master chooses CDM before it has CDS.
  bool ahead = false;

 private:
  template <std::size_t... K>
  std::array<Server, Count> make(std::index_sequence<K...>) {
    return {Server({&registers[K]}, options_)...};
  }

  RegisterServerOptions options_;
  std::array<Server, Count> servers_;
  Damage damage_;
  std::uint32_t frame_ = 0;
};

/// The value that fill() writes there.
constexpr std::uint8_t value_of(std::size_t slave, unsigned address) {
  return static_cast<std::uint8_t>(address * 37U + slave * 101U + 5U);
}

/// Sets every register of every slave to a different value.
template <std::size_t Count>
void fill(ControlLink<Count>& link) {
  for (std::size_t k = 0; k < Count; ++k) {
    for (unsigned address = 0; address < register_count; ++address) {
      link.registers[k].value[address] = value_of(k, address);
    }
  }
}

}  // namespace biss::test
