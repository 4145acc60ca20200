// An encoder that answers the design's master: biss_slave with a cable and faults.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capi/biss_c.h"
#include "sim/random.hpp"
#include "simulators/cable.hpp"
#include "simulators/instance.hpp"

namespace biss::simulators {

class Encoder final : public Instance {
 public:
  Encoder(std::string name, Settings settings);

  /// Call it at each change of MA and at the time returned.
  std::int64_t step(std::int64_t now, bool ma);
  bool level() const override { return slo_.received(); }
  /// The next frame has this value, in place of the value of the settings.
  void set_next(std::size_t channel, const biss_channel& value) { next_[channel] = value; }
  bool compare(const std::string& cause) override;
  void finish() override;

 private:
  // The place in the frame: START is slot 0, CDS 1, then the payload and STOP.
  static constexpr int before_start = -1;

  void open_slave(Picoseconds processing);
  void advance(std::int64_t now);
  void take_edge(std::int64_t now, bool level);
  void begin_request(std::int64_t now);
  void measure_clock(std::int64_t now, bool level);
  void choose_values(sim::Random& random);
  void choose_damage(sim::Random& random);
  void drive(std::int64_t now, bool level);
  void end_request(std::int64_t now);
  void check_clock(std::int64_t now);
  void deliver(std::int64_t now);
  bool faulty_level(bool level) const;
  bool is_in_progress() const;
  std::int64_t deadline() const;
  Picoseconds next_line_delay() const;
  int stop_slot() const { return 2 + static_cast<int>(settings().format.payload_bits()); }

  static void sample(void* user, std::int64_t moment, biss_channel* channels, std::size_t count);
  static bool permits(void* user, bool write, std::uint8_t address);
  static int read_register(void* user, std::uint8_t address);
  static void write_register(void* user, std::uint8_t address, std::uint8_t value);

  biss_slave slave_{};
  Picoseconds processing_{};
  biss_output output_{true, BISS_NEVER};
  Cable ma_;
  Cable slo_;
  sim::Random jitter_;
  bool driven_ = true;
  std::array<std::optional<biss_channel>, BISS_MAX_CHANNELS> next_{};
  std::map<std::uint8_t, std::uint8_t> registers_;
  std::size_t crc_flips_ = 0;
  std::int64_t now_ = 0;
  bool live_ = false;  // MA was high once

  // The request that is running.
  bool running_ = false;
  bool delivered_ = false;
  bool reported_ = false;
  Fault fault_ = Fault::none;
  Outcome outcome_;
  Picoseconds line_delay_{};
  int slot_ = before_start;
  std::vector<bool> damaged_;  // by slot
  std::string damage_;         // the case of the coverage
  int clocks_ = 0;
  int start_clock_ = 0;
  bool early_ = false;
  bool overloaded_ = false;
  std::int64_t last_edge_ = 0;
  std::int64_t last_rise_ = 0;
  Picoseconds shortest_period_{};
  Picoseconds longest_period_{};
  // The delay of SLO's first edge by jitter; later edges are compared with it.
  std::optional<std::int64_t> first_late_;
  std::int64_t earliest_ = 0;
  std::int64_t latest_ = 0;
};

}  // namespace biss::simulators
