// Rules on control communication, registers and the data sheet in them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>

#include "biss/frame/codec.hpp"
#include "decode/control_listener.hpp"
#include "decode/cycle.hpp"
#include "decode/rules.hpp"
#include "decode/seen_registers.hpp"

namespace biss::decode {

class ControlRules {
 public:
  ControlRules(const std::optional<FrameFormat>& format, Tallies& tallies);
  ControlRules(const ControlRules&) = delete;
  ControlRules& operator=(const ControlRules&) = delete;

  void push(std::uint64_t number, const Cycle& cycle);
  void finish();

  /// The rule of that name, by all registers so far.
  RuleResult data_sheet() const;
  /// Both registers of the manufacturer of one slave were read.
  bool manufacturer_seen() const;

 private:
  // A register that was accessed; its P announced that the next one can be accessed.
  struct Announced {
    std::uint8_t id = 0;
    SeenAccess::Kind kind = SeenAccess::Kind::unknown;
    std::uint8_t next = 0;
  };

  void count(Rule rule, bool good, std::uint64_t cycle, std::string_view note = {});
  void judge_stated_crc(std::uint64_t number, const Cycle& cycle);
  void watch_silence(std::uint64_t number, const Cycle& cycle);
  void watch_stray(std::uint64_t number, const Cycle& cycle);

  void judge_access(const SeenAccess& access);
  void judge_ids(const SeenAccess& access);
  void judge_register(const SeenAccess& access);
  void judge_write(const SeenAccess& access);
  void judge_next(const SeenAccess& access);
  void judge_manufacturer(const SeenAccess& access);
  void judge_profile(const SeenAccess& access, const SeenRegisters& seen);

  std::optional<FrameFormat> format_;
  Tallies& tallies_;
  ControlListener listener_;
  std::map<unsigned, SeenRegisters> slaves_;
  std::map<unsigned, std::uint64_t> last_access_;
  std::array<unsigned, control_max_slaves> manufacturer_seen_{};
  std::optional<Announced> announced_;
  // By the profile identifier of the only slave, if no format was given.
  std::optional<FrameCodec<>> stated_;
  // The period of the last cycle that has one.
  Picoseconds period_{};
  // Zeros of CDM since the last 1 or the last missing cycle.
  unsigned zeros_ = 0;
  bool settled_ = false;
  unsigned silence_left_ = 0;
  std::uint64_t damaged_at_ = 0;
  bool answered_ = false;
  bool broken_off_ = false;
  bool control_off_ = false;
};

}  // namespace biss::decode
