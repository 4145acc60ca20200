// Shared by the checks of all parts: the options, and the check of each field by its table.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/finding.hpp"

namespace biss {

/// Options for facts that no document defines.
struct EdsCheckOptions {
  /// 0 and all ones mark an optional value that is not given (inferred: the ranges exclude just
  /// these two). False: they are out of range.
  bool zero_is_absent = true;
  bool ones_are_absent = true;
  /// Bytes and bits that no source names must be 0: common part 0x13, bits 2 and 4…7 of FORMAT_i,
  /// 5…7 of BC_OFF.
  bool unnamed_zero = false;

  /// Whether a value of an optional field means that it is not given.
  constexpr bool absent(std::uint32_t value, std::uint32_t all_ones) const {
    return (zero_is_absent && value == 0) || (ones_are_absent && value == all_ones);
  }
};

}  // namespace biss

namespace biss::eds_detail {

// One part under test, and the receiver of its findings.
template <EdsSink Sink>
class PartCheck {
 public:
  constexpr PartCheck(const EdsBank& checked, EdsPart part, std::uint8_t number,
                      const EdsCheckOptions& given, Sink& sink)
      : bank_(checked), options_(given), part_(part), channel_(number), sink_(sink) {}

  constexpr void report(EdsProblem problem, std::string_view symbol, std::uint32_t value,
                        std::string_view against = {}, std::uint32_t expected = 0) const {
    sink_(EdsFinding{part_, channel_, symbol, problem, value, against, expected});
  }

  // Reports a bank that is empty or erased; true when it is.
  constexpr bool check_filling(std::string_view first) const {
    const bool zero = is_filled_with(bank_, 0x00);
    if (!zero && !is_filled_with(bank_, 0xFF)) return false;
    report(zero ? EdsProblem::all_zero : EdsProblem::all_ones, first, bank_[0]);
    return true;
  }

  constexpr void check_sum() const {
    const std::uint8_t stored = bank_[eds_checksum_address];
    const std::uint8_t computed = eds_checksum(bank_);
    if (stored != computed) report(EdsProblem::checksum, "CHKSUM", stored, {}, computed);
  }

  constexpr void check_values(std::span<const EdsField> fields) const {
    for (const EdsField& field : fields) check_value(field, field_value(bank_, field));
  }

  // Reports two given limits in the wrong order.
  constexpr void check_order(std::string_view low_symbol, std::uint32_t low,
                             std::string_view high_symbol, std::uint32_t high,
                             std::uint32_t all_ones) const {
    if (options_.absent(low, all_ones) || options_.absent(high, all_ones) || low <= high) return;
    report(EdsProblem::min_above_max, low_symbol, low, high_symbol, high);
  }

 protected:
  const EdsBank& bank_;
  const EdsCheckOptions& options_;

 private:
  // Checks the range of a plain value, and bytes that must be 0.
  constexpr void check_value(const EdsField& field, std::uint32_t value) const {
    // The documents do not state that reserved bytes must be 0.
    if (field.kind == EdsKind::reserved && value != 0) {
      report(EdsProblem::reserved_not_zero, field.symbol, value);
    }
    if (field.kind == EdsKind::unnamed && options_.unnamed_zero && value != 0) {
      report(EdsProblem::unnamed_not_zero, field.symbol, value);
    }
    // These have checks of their own.
    if (field.kind == EdsKind::feedback || field.kind >= EdsKind::identifier) return;
    if (field.in_range(value)) return;
    if (field.may_be_absent() && options_.absent(value, field.all_ones())) return;
    report(EdsProblem::out_of_range, field.symbol, value);
  }

  EdsPart part_;
  std::uint8_t channel_;
  Sink& sink_;
};

}  // namespace biss::eds_detail
