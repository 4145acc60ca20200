// What the checks of all parts share: reporting, and the rules a single field must keep.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/crc/spec.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/finding.hpp"

namespace biss::eds_detail {

// One part under test and where its findings go.
template <EdsSink Sink>
struct PartReport {
  Sink& sink;
  EdsPart part = EdsPart::common;
  std::uint8_t channel = 0;

  constexpr void operator()(EdsProblem problem, std::string_view symbol, std::uint32_t value,
                            std::string_view against = {}, std::uint32_t expected = 0) const {
    sink(EdsFinding{part, channel, symbol, problem, value, against, expected});
  }
};

// A whole bank that says nothing. True when it is one, and reported.
template <class Report>
constexpr bool check_filling(const EdsBank& bank, std::string_view first, const Report& report) {
  if (is_filled_with(bank, 0x00)) {
    report(EdsProblem::all_zero, first, 0x00);
    return true;
  }
  if (is_filled_with(bank, 0xFF)) {
    report(EdsProblem::all_ones, first, 0xFF);
    return true;
  }
  return false;
}

template <class Report>
constexpr void check_sum(const EdsBank& bank, const Report& report) {
  const std::uint8_t stored = bank[eds_checksum_address];
  const std::uint8_t computed = eds_checksum(bank);
  if (stored != computed) report(EdsProblem::checksum, "CHKSUM", stored, {}, computed);
}

// The range of a plain value, and bytes that must be 0.
template <class Report>
constexpr void check_value(const EdsField& field, std::uint32_t value,
                           const EdsCheckOptions& options, const Report& report) {
  switch (field.kind) {
    case EdsKind::reserved:
      if (options.reserved_zero && value != 0) {
        report(EdsProblem::reserved_not_zero, field.symbol, value);
      }
      return;
    case EdsKind::unnamed:
      if (options.unnamed_zero && value != 0) {
        report(EdsProblem::unnamed_not_zero, field.symbol, value);
      }
      return;
    case EdsKind::identifier:
    case EdsKind::polynomial:
    case EdsKind::channel_format:
    case EdsKind::bus_coupler:
    case EdsKind::checksum:
      return;  // have checks of their own
    default:
      break;
  }
  if (field.in_range(value)) return;
  if (field.may_be_absent() && options.absent(value, field.all_ones())) return;
  report(EdsProblem::out_of_range, field.symbol, value);
}

template <class Report>
constexpr void check_values(const EdsBank& bank, std::span<const EdsField> fields,
                            const EdsCheckOptions& options, const Report& report) {
  for (const EdsField& field : fields) {
    check_value(field, field_value(bank, field), options, report);
  }
}

// Both given, and the wrong way round.
template <class Report>
constexpr void check_order(std::string_view low_symbol, std::uint32_t low,
                           std::string_view high_symbol, std::uint32_t high, std::uint32_t all_ones,
                           const EdsCheckOptions& options, const Report& report) {
  if (options.absent(low, all_ones) || options.absent(high, all_ones) || low <= high) return;
  report(EdsProblem::min_above_max, low_symbol, low, high_symbol, high);
}

// A polynomial of BiSS as it stands in code, with the lowest bit that the data sheet leaves out.
constexpr bool is_full_form_of_known(std::uint32_t stored) {
  constexpr std::uint32_t ccitt = 0x11021;  // in BP3's history, 0x8810 (Rev A2)
  if (stored == ccitt) return true;
  for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
    if (stored != 0 && stored == default_polynomial(width)) return true;
  }
  return false;
}

// Width of the CRC whose polynomial is stored without its lowest bit.
constexpr unsigned stored_crc_bits(std::uint32_t stored) {
  return static_cast<unsigned>(std::bit_width(stored));
}

}  // namespace biss::eds_detail
