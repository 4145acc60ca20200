// The quick way through the value changes of a VCD, for two of its lines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "capture/declared_lines.hpp"
#include "capture/text_source.hpp"
#include "capture/timescale.hpp"
#include "capture/vcd_words.hpp"

namespace biss::capture {

/// The content of the declarations of a VCD.
struct VcdSignals {
  Timescale timescale;
  VcdIds ids;
  DrivenLines driven;  ///< a variable is the number of an identifier
};

/// The meaning of identifiers for a pair of lines. Refers to the signals of the reader, and only
/// reads data that does not change.
class VcdPair {
 public:
  enum Role : std::uint8_t { ma, slo, other, undeclared };

  /// \pre the lines have different variables
  VcdPair(const VcdSignals& signals, std::uint32_t ma_variable, std::uint32_t slo_variable);

  Role role_of(char id) const { return roles_[static_cast<unsigned char>(id)]; }
  Role role_of(std::uint32_t variable) const {
    if (variable == VcdIds::none) return undeclared;
    if (variable == ma_variable_) return ma;
    return variable == slo_variable_ ? slo : other;
  }
  const VcdSignals& signals() const { return *signals_; }
  std::uint32_t ma_variable() const { return ma_variable_; }
  std::uint32_t slo_variable() const { return slo_variable_; }

 private:
  const VcdSignals* signals_;
  std::uint32_t ma_variable_;
  std::uint32_t slo_variable_;
  std::array<Role, 256> roles_;
};

/// A piece of a VCD. Times in order, values of declared identifiers, and levels 0 and 1 of the two
/// lines are regular. Keywords, comments, unknown levels of the lines and invalid text are not.
class VcdPiece final : public TextPiece {
 public:
  /// `pair` outlives the piece.
  explicit VcdPiece(const VcdPair& pair) : pair_(&pair) {}

  // In a regular piece:
  bool timed = false;            ///< it has a time
  std::uint64_t first_tick = 0;  ///< when timed
  std::uint64_t last_tick = 0;   ///< when timed
  std::size_t early_ma = 0;      ///< changes before the first time; they have none yet
  std::size_t early_slo = 0;

 private:
  bool quick_parse() override;

  const VcdPair* pair_;
};

}  // namespace biss::capture
