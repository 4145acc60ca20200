// An encoder judged by what a capture shows of it, rule by rule.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/control_listener.hpp"
#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "decode/seen_registers.hpp"

namespace biss::decode {

/// The rules of docs/conform.md.
enum class Rule : std::uint8_t {
  frame_structure,
  frame_crc,
  ack_shortest,
  ack_longest,
  timeout_shortest,
  timeout_longest,
  line_delay,
  slo_idle,
  cds_idle,
  id_answer,
  id_pattern,
  header_damaged,
  rw_pattern,
  refusal,
  data_crc,
  write_start,
  write_echo,
  busy,
  next_register,
  manufacturer,
  profile,
  data_sheet,
  control_reset,
  clock_max,
  clock_min,
  clock_change,
  cycle_min,
};

inline constexpr std::size_t rule_count = 27;

struct RuleText {
  std::string_view name;
  /// `ns` where a time is judged, else what is counted; the limit of a count is 0.
  std::string_view unit;
  /// Where the rule is written.
  std::string_view source;
};
const RuleText& text_of(Rule rule);

enum class Verdict : std::uint8_t {
  pass,
  fail,
  marginal,    ///< beyond the limit by at most the measurement uncertainty
  not_judged,  ///< the capture holds no case
};
std::string_view name_of(Verdict verdict);

struct RuleResult {
  Verdict verdict = Verdict::not_judged;
  std::uint64_t cases = 0;
  std::uint64_t faults = 0;
  /// The limit of a time, the worst time seen, and its margin to the limit; negative: beyond it.
  struct Time {
    Picoseconds limit{};
    Picoseconds worst{};
    Picoseconds margin{};
  };
  /// Only where a time is judged and one was seen.
  std::optional<Time> time;
  /// Cycle of the worst time, or of the first fault.
  std::optional<std::uint64_t> cycle;
  /// What was wrong, for a reader.
  std::string note;
};

/// Takes every cycle. Bounded memory.
class Conformance {
 public:
  /// Without a format frames are judged by their structure, and by the profile identifier as soon
  /// as the only slave was asked for it. A timeout of just the default is taken as unknown: either
  /// rule will do.
  Conformance(const std::optional<FrameFormat>& format, const DeviceTiming& timing);
  Conformance(const Conformance&) = delete;
  Conformance& operator=(const Conformance&) = delete;

  void push(std::uint64_t number, const Cycle& cycle);
  void finish();

  RuleResult result(Rule rule) const;

 private:
  struct Tally {
    std::uint64_t cases = 0;
    std::uint64_t faults = 0;
    std::optional<RuleResult::Time> time;
    Picoseconds doubt{};
    std::optional<std::uint64_t> cycle;
    std::string note;
  };
  // A register that was accessed, and of which P said that the next one can be.
  struct Announced {
    std::uint8_t id = 0;
    SeenAccess::Kind kind = SeenAccess::Kind::unknown;
    std::uint8_t next = 0;
  };

  Tally& tally(Rule rule) { return tallies_[static_cast<std::size_t>(rule)]; }
  void count(Rule rule, bool good, std::uint64_t cycle, std::string_view note = {});
  void at_most(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
               std::uint64_t cycle);
  void at_least(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                std::uint64_t cycle);
  void measure(Rule rule, const RuleResult::Time& time, Picoseconds doubt, std::uint64_t cycle);

  void judge_master(std::uint64_t number, const Cycle& cycle);
  void judge_frame(std::uint64_t number, const Cycle& cycle);
  void judge_times(std::uint64_t number, const Cycle& cycle);
  void judge_timeout(std::uint64_t number, const Cycle& cycle);
  void judge_idle(std::uint64_t number, const Cycle& cycle);
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
  DeviceTiming timing_;
  LimitWatch limits_;
  std::array<Tally, rule_count> tallies_{};
  ControlListener listener_;
  std::map<unsigned, SeenRegisters> slaves_;
  std::map<unsigned, std::uint64_t> last_access_;
  std::array<unsigned, control_max_slaves> manufacturer_seen_{};
  std::optional<Announced> announced_;
  // By the profile identifier of the only slave, where no format was given.
  std::optional<FrameCodec<>> stated_;
  // The longest request that was answered with a frame, in rising edges of MA.
  std::uint32_t usual_edges_ = 0;
  // Of the request before: SLO is due to be high again by then.
  std::optional<Picoseconds> ready_by_;
  // Zeros of CDM since the last 1 or the last cycle not heard.
  unsigned zeros_ = 0;
  bool settled_ = false;
  unsigned silence_left_ = 0;
  std::uint64_t damaged_at_ = 0;
  bool answered_ = false;
  bool broken_off_ = false;
  bool control_off_ = false;
};

}  // namespace biss::decode
