// Checks a BP3 part, alone and against the other facts about its channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/crc/spec.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/part_check.hpp"
#include "biss/eds/profile.hpp"

namespace biss {

/// Data outside the part that should agree with it.
struct Bp3Context {
  std::uint8_t channel = 0;
  /// Registers 0x42 (upper byte) and 0x43 of the slave.
  std::optional<std::uint16_t> identifier{};
  /// DLEN_i of the common part.
  std::optional<std::uint8_t> dlen{};
  /// Whether the device sends a safety position word (BP3S), too; empty: not known.
  std::optional<bool> safety_encoder{};
};

namespace eds_detail {

// BP3 Rev A3, table 5: C = 1 is mandatory within a safety encoder, and C = 0 is expected within a
// standard encoder.
constexpr bool crc_bit_is_wrong(ProfileIdentifier id, std::optional<bool> safety_encoder) {
  return safety_encoder && id.crc_is_data() != *safety_encoder;
}

template <EdsSink Sink>
class Bp3Check : PartCheck<Sink> {
  using Base = PartCheck<Sink>;
  using Base::report, Base::bank_, Base::options_;

 public:
  constexpr Bp3Check(const EdsBank& checked, const Bp3Context& context,
                     const EdsCheckOptions& given, Sink& sink)
      : Base(checked, EdsPart::bp3, context.channel, given, sink),
        part_(parse_bp3_part(checked)),
        id_{part_.bp_id},
        context_(context) {}

  constexpr void run() const {
    if (this->check_filling("BP_VER")) return;
    if (part_.bp_ver != 1) report(EdsProblem::version, "BP_VER", part_.bp_ver, {}, 1);
    // The version row has the range 1…1 and would be reported twice.
    this->check_values(std::span(bp3_fields).subspan(1));
    check_feedback();
    check_polynomial();
    check_orders();
    if (part_.mt_len != 0 && part_.mt_fmt == 1) {
      report(EdsProblem::alignment, "MT_FMT", part_.mt_fmt, "MT_LEN", 0);
    }
    const bool length_known = check_identifier();
    if (lengths_in_range()) check_counts(!length_known || check_lengths());
    this->check_sum();
  }

 private:
  constexpr bool lengths_in_range() const {
    return part_.mt_len <= bp3_max_length_bits && part_.co_len <= bp3_max_length_bits &&
           part_.fi_len <= bp3_max_length_bits;
  }

  // True when DL can be compared with the lengths.
  constexpr bool check_identifier() const {
    const std::uint32_t id = part_.bp_id;
    const auto bad = [&](EdsProblem problem, std::uint32_t expected = 0) {
      report(problem, "BP_ID", id, {}, expected);
      return false;
    };
    if (context_.identifier && *context_.identifier != id) {
      const bool swapped = bytes_swapped(id, 2) == *context_.identifier;
      return bad(swapped ? EdsProblem::little_endian : EdsProblem::identifier,
                 *context_.identifier);
    }
    if (id_.profile() != Profile::bp3) {
      if (is_swapped_bp3(part_.bp_id)) return bad(EdsProblem::little_endian, bytes_swapped(id, 2));
      return bad(EdsProblem::profile);
    }
    if (id_.version() != 1) return bad(EdsProblem::version);
    if (id_.bit7()) return bad(EdsProblem::reserved_bit);
    const unsigned most = id_.crc_is_data() ? bp3_max_length_crc_is_data : bp3_max_data_bits;
    if (id_.data_length() < bp3_min_data_bits || id_.data_length() > most) {
      return bad(EdsProblem::data_length);
    }
    if (crc_bit_is_wrong(id_, context_.safety_encoder)) report(EdsProblem::crc_bit, "BP_ID", id);
    return true;
  }

  // Without nE (1) in either bit, a reader cannot detect which positions are good.
  constexpr void check_feedback() const {
    if (part_.fb1 != 1) {
      report(EdsProblem::out_of_range, "FB1", part_.fb1, part_.fb2 != 1 ? "FB2" : "", part_.fb2);
    }
    if (part_.fb2 != 2) report(EdsProblem::out_of_range, "FB2", part_.fb2);
  }

  // DL computed from the lengths.
  constexpr unsigned data_length_of_parts() const {
    return part_.position_bits() + 2 + (id_.crc_is_data() ? crc6.width_bits : 0U);
  }

  // The same sum decides which reading a decoder takes.
  constexpr bool fits_other_reading() const {
    return id_.crc_is_data() && part_.position_bits() + 2 == id_.data_length();
  }

  constexpr bool check_lengths() const {
    const unsigned sum = data_length_of_parts();
    if (sum == id_.data_length()) return true;
    if (fits_other_reading()) {
      report(EdsProblem::length_reading, "BP_ID", part_.bp_id, "FI_LEN", id_.with_length(sum).raw);
      return false;
    }
    const std::string_view suspect = suspect_length(part_);
    const bool registers = context_.identifier.has_value();  // and they agree, or we were not here
    const bool outvoted = context_.dlen == sum;
    if (!registers && (outvoted || suspect.empty())) {
      report(EdsProblem::lengths, "BP_ID", part_.bp_id, "FI_LEN", id_.with_length(sum).raw);
      return false;
    }
    const std::string_view symbol = suspect.empty() ? "FI_LEN" : suspect;
    const std::uint32_t value = symbol == "MT_LEN"   ? part_.mt_len
                                : symbol == "CO_LEN" ? part_.co_len
                                                     : part_.fi_len;
    const std::uint32_t expected = value + id_.data_length() - sum;
    report(EdsProblem::lengths, symbol, value, "BP_ID", expected <= 57 ? expected : 0);
    return false;
  }

  // Only if the lengths are right: consequences of a wrong length are not reported.
  constexpr void check_counts(bool lengths_hold) const {
    if (!lengths_hold || part_.en_typ > 1) return;
    if (counts_of_type_fit(part_)) return check_alignment();
    if (type_is_wrong()) {
      report(EdsProblem::encoder_type, "EN_TYP", part_.en_typ, "MT_CNT", 1U - part_.en_typ);
      return;
    }
    if (part_.linear()) {
      check_pair("MT_CNT", part_.mt_cnt, part_.position_bits());
      return;
    }
    if (!turns_fit(part_)) {
      const std::uint32_t swapped = bytes_swapped(part_.mt_cnt, 4);
      const bool order = looks_swapped(part_.mt_cnt, 1, part_.mt_len);
      report(order ? EdsProblem::little_endian : EdsProblem::count_above_length, "MT_CNT",
             part_.mt_cnt, "MT_LEN", order ? swapped : part_.mt_len);
    }
    if (!periods_fit(part_)) {
      check_pair("SIP_CNT", part_.sip_cnt, singleturn_bits(part_));
    }
  }

  // A right-aligned singleturn value that fills its field is left-aligned, too.
  constexpr void check_alignment() const {
    const Bp3Zeros zeros = part_.linear() ? scale_zeros(part_) : singleturn_zeros(part_);
    const bool leading = zeros.leading != 0 && !(part_.linear() && part_.mt_len != 0);
    if (!leading && !zeros.inside) return;
    const bool fine = part_.fi_len != 0 && part_.fi_fmt != 1;
    const std::string_view symbol = fine ? "FI_FMT" : "CO_FMT";
    const std::string_view upper = part_.linear() && part_.mt_len != 0 ? "MT_FMT" : "CO_FMT";
    report(EdsProblem::alignment, symbol, fine ? part_.fi_fmt : part_.co_fmt,
           zeros.inside ? upper
           : fine       ? "SIP_RES"
                        : "SIP_CNT",
           1);
  }

  // Everything fits the other type, including the checksum, and no count would fit with one changed
  // byte.
  constexpr bool type_is_wrong() const {
    EdsBank other = bank_;
    other[0x08] ^= 1U;
    if (other[eds_checksum_address] != eds_checksum(other)) return false;
    if (!counts_of_type_fit(parse_bp3_part(other))) return false;
    for (std::size_t at = 0x10; at < 0x1C; ++at) {
      other = bank_;
      other[at] = static_cast<std::uint8_t>(other[at] + (part_.linear() ? -1 : 1));
      if (counts_of_type_fit(parse_bp3_part(other))) return false;
    }
    return true;
  }

  // Whether a count in the other byte order, times `other`, is the count for which the length was
  // chosen. A count that fits alone may be right, unless other fields are in the wrong order.
  constexpr bool looks_swapped(std::uint32_t given, std::uint64_t other, unsigned bits) const {
    const bool all_swapped =
        bytes_swapped(part_.cpoly, 4) == crc6.polynomial >> 1U || is_swapped_bp3(part_.bp_id);
    return bits != 0 && just_fits(count_or_one(bytes_swapped(given, 4)) * other, bits) &&
           (all_swapped || !counts_fit(count_or_one(given), bits));
  }

  // A count times SIP_RES is too large for `bits`: finds out whether the byte order is wrong, or
  // which value is.
  constexpr void check_pair(std::string_view symbol, std::uint32_t count, unsigned bits) const {
    const bool scale = symbol == "MT_CNT";
    const std::uint32_t res = part_.sip_res;
    const std::uint32_t count_swapped = bytes_swapped(count, 4);
    const std::uint32_t res_swapped = bytes_swapped(res, 4);
    const bool res_order = looks_swapped(res, count_or_one(count), bits);
    const bool count_order = looks_swapped(count, count_or_one(res), bits);
    const bool both = !res_order && !count_order &&
                      looks_swapped(res, count_or_one(count_swapped), bits) &&
                      looks_swapped(count, count_or_one(res_swapped), bits);
    if (count_order || both) {
      report(EdsProblem::little_endian, symbol, count, "SIP_RES", count_swapped);
    }
    if ((res_order && !count_order) || both) {
      report(EdsProblem::little_endian, "SIP_RES", part_.sip_res, symbol, res_swapped);
    }
    if (res_order || count_order || both) return;
    const bool count_alone = !counts_fit(count_or_one(count), bits) ||
                             (!scale && part_.co_len != 0 && !counts_fit(count, part_.co_len));
    // One period fills the length.
    const bool no_room = !scale && just_fits(count_or_one(part_.sip_res), bits);
    if (count_alone || no_room) {
      report(EdsProblem::count_above_length, symbol, count, "SIP_RES", part_.sip_res);
    } else {
      report(EdsProblem::count_above_length, "SIP_RES", part_.sip_res, symbol, count);
    }
  }

  constexpr void check_polynomial() const {
    const std::uint32_t stored = part_.cpoly;
    constexpr std::uint32_t due = crc6.polynomial >> 1U;
    if (stored == due) return;
    // BP3 states its polynomial with the condition C = 0.
    if (stored == 0 && id_.profile() == Profile::bp3 && id_.crc_is_data()) return;
    if (bytes_swapped(stored, 4) == due) {
      report(EdsProblem::little_endian, "CPOLY", stored, {}, due);
    } else if (is_full_form_of_known(stored)) {
      report(EdsProblem::polynomial_full_form, "CPOLY", stored, {}, stored >> 1U);
    } else {
      report(EdsProblem::polynomial, "CPOLY", stored, {}, due);
    }
  }

  // No encoder works above this; with its bytes swapped, the value may be an ordinary temperature.
  static constexpr std::uint32_t plausible_kelvin_max = 1000;

  constexpr bool kelvin_swapped(std::string_view symbol, std::uint32_t value) const {
    const std::uint32_t swapped = bytes_swapped(value, 2);
    if (options_.absent(value, ones16) || value <= plausible_kelvin_max || swapped == 0 ||
        swapped > plausible_kelvin_max) {
      return false;
    }
    report(EdsProblem::little_endian, symbol, value, {}, swapped);
    return true;
  }

  constexpr void check_orders() const {
    const bool low = kelvin_swapped("TMP_MIN", part_.tmp_min);
    const bool high = kelvin_swapped("TMP_MAX", part_.tmp_max);
    if (!low && !high) {
      this->check_order("TMP_MIN", part_.tmp_min, "TMP_MAX", part_.tmp_max, ones16);
    }
    this->check_order("VLT_MIN", part_.vlt_min, "VLT_MAX", part_.vlt_max, ones16);
  }

  Bp3Part part_;
  ProfileIdentifier id_;
  const Bp3Context& context_;
};

}  // namespace eds_detail

/// Reports all findings of a BP3 part. A field is reported once; consequences of another finding
/// are not reported.
template <EdsSink Sink>
constexpr void check_bp3_part(const EdsBank& bank, Sink&& sink, const Bp3Context& context = {},
                              const EdsCheckOptions& options = {}) {
  using PlainSink = std::remove_reference_t<Sink>;
  eds_detail::Bp3Check<PlainSink>(bank, context, options, sink).run();
}

}  // namespace biss
