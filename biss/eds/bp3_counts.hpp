// Whether the lengths of a BP3 position and the counts it is said to have go together.
//
// Rotary: MT counts MT_CNT revolutions, coarse and fine the SIP_CNT x SIP_RES counts of one. Both
// may have bits to spare: MT leading, singleturn trailing zeros. Linear: SIP_CNT is a length in nm
// and multiplies nothing; the MT_CNT distinguishable periods of SIP_RES counts each must fit into
// the whole position, however it is divided. A count that is not given (0, all ones) counts as one.
#pragma once

#include <cstdint>
#include <string_view>

#include "biss/eds/bp3_part.hpp"

namespace biss::eds_detail {

// Whether so many bits can count so many values; more than 63 always can.
constexpr bool counts_fit(std::uint64_t counts, unsigned bits) {
  return bits > 63 || counts <= std::uint64_t{1} << bits;
}

// Whether a length is the shortest that counts so many: what a maker chooses.
constexpr bool just_fits(std::uint64_t counts, unsigned bits) {
  return counts_fit(counts, bits) && (bits == 0 || !counts_fit(counts, bits - 1));
}

constexpr bool count_given(std::uint32_t count) { return count != 0 && count != ones32; }
constexpr std::uint64_t count_or_one(std::uint32_t count) { return count_given(count) ? count : 1; }

constexpr unsigned singleturn_bits(const Bp3Part& part) {
  return unsigned{part.co_len} + part.fi_len;
}
constexpr std::uint64_t counts_a_turn(const Bp3Part& part) {
  return count_or_one(part.sip_cnt) * count_or_one(part.sip_res);
}

constexpr bool turns_fit(const Bp3Part& part) {
  return counts_fit(count_or_one(part.mt_cnt), part.mt_len);
}
constexpr bool periods_fit(const Bp3Part& part) {
  return counts_fit(counts_a_turn(part), singleturn_bits(part));
}
constexpr bool scale_fits(const Bp3Part& part) {
  return counts_fit(count_or_one(part.mt_cnt) * count_or_one(part.sip_res), part.position_bits());
}
constexpr bool counts_of_type_fit(const Bp3Part& part) {
  return part.linear() ? scale_fits(part) : turns_fit(part) && periods_fit(part);
}

// The one length of a rotary encoder that its count does not bear out; empty when the counts tell
// nothing.
constexpr std::string_view suspect_length(const Bp3Part& part) {
  if (part.linear()) return {};
  if (count_given(part.mt_cnt) && !just_fits(part.mt_cnt, part.mt_len)) return "MT_LEN";
  if (!count_given(part.sip_cnt) || !count_given(part.sip_res)) return {};
  if (just_fits(counts_a_turn(part), singleturn_bits(part))) return {};
  return part.co_len != 0 && !just_fits(part.sip_cnt, part.co_len) ? "CO_LEN" : "FI_LEN";
}

}  // namespace biss::eds_detail
