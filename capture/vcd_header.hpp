// The declarations of a VCD: time scale, scopes and signals, up to $enddefinitions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/vcd_ids.hpp"

namespace biss::capture {

/// Ticks of a VCD to picoseconds: a whole factor, or for femtoseconds a divisor.
struct VcdTimescale {
  std::uint64_t factor = 0;  ///< picoseconds a tick; 0 while no time scale is known
  std::uint64_t divisor = 1;

  bool known() const { return factor != 0; }
  /// The last tick that picoseconds can hold.
  std::uint64_t last_tick() const;
  /// \pre ticks <= last_tick(). Halves are rounded up.
  Picoseconds time_of(std::uint64_t ticks) const;

  bool operator==(const VcdTimescale&) const = default;
};

/// `1ns`, `10 us`, `100fs`, without white space; not known() for anything else.
VcdTimescale parse_vcd_timescale(std::string_view text);

/// Whom a value of an identifier concerns: `lines` entries of VcdSignals::driven from `first`.
/// None for what is no line: vectors, reals, strings, events.
struct VcdVariable {
  std::uint32_t first = 0;
  std::uint32_t lines = 0;
};

/// What the declarations say once they are complete.
struct VcdSignals {
  VcdTimescale timescale;
  VcdIds ids;
  std::vector<VcdVariable> variables;   ///< indexed by the number of the identifier
  std::vector<wire::LineIndex> driven;  ///< the lines of each variable, one after the other
  std::vector<std::string> lines;
};

/// Takes the declarations word by word.
///
/// Each one-bit `$var` is a line. Its name is the plain one, `top.cap.MA` with its scopes where
/// another line is called the same. Signals of the same name and the same identifier are one line;
/// signals of another name and the same identifier are lines that change together. A bit
/// `MA [3]` is called `MA[3]`; the range `[0:0]` of a one-bit signal is left out.
class VcdHeader {
 public:
  enum class Step : std::uint8_t { more, done, failed };

  /// The next word. After `done` the signals are complete.
  Step feed(std::string_view word);

  /// Text that is skipped up to `$end`; its words may have any length.
  bool in_comment() const { return section_ == Section::comment; }
  bool started() const { return started_; }
  CaptureCause cause() const { return cause_; }
  const char* expected() const { return expected_; }
  VcdSignals& signals() { return signals_; }

 private:
  enum class Section : std::uint8_t { none, comment, timescale, var, scope, upscope, end };

  static constexpr std::size_t max_words = 64;
  static constexpr std::size_t max_scopes = 256;
  static constexpr std::size_t max_variables = 1U << 20U;
  static constexpr std::size_t max_stored_bytes = 64U << 20U;

  struct Scope {
    std::string name;
    std::uint32_t parent;
  };
  struct Signal {
    std::string name;
    std::uint32_t scope;
    std::uint32_t variable;
  };

  Step fail(CaptureCause cause, const char* expected);
  Step malformed(const char* expected) { return fail(CaptureCause::malformed, expected); }
  Step begin_section(std::string_view keyword);
  Step end_section();
  Step end_timescale();
  Step end_var();
  Step end_scope();
  Step end_upscope();
  Step end_definitions();
  bool store(std::size_t bytes);
  std::string path_of(const Signal& signal) const;
  bool name_lines();
  void connect_lines();

  Section section_ = Section::none;
  bool started_ = false;
  std::vector<std::string> words_;
  std::vector<Scope> scopes_;
  std::vector<std::uint32_t> open_scopes_;
  std::vector<Signal> lines_;
  std::size_t stored_bytes_ = 0;
  VcdSignals signals_;
  CaptureCause cause_{};
  const char* expected_ = nullptr;
};

}  // namespace biss::capture
