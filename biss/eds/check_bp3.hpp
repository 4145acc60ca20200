// What can be told wrong about a BP3 part, alone and beside what else is known of its channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_counts.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/check_field.hpp"
#include "biss/eds/finding.hpp"
#include "biss/eds/profile.hpp"
#include "biss/eds/profile_identifier.hpp"

namespace biss {

/// What stands outside the part and should agree with it.
struct Bp3Context {
  std::uint8_t channel = 0;
  /// Registers 0x42 (upper byte) and 0x43 of the slave.
  std::optional<std::uint16_t> identifier{};
  /// DLEN_i of the common part.
  std::optional<std::uint8_t> dlen{};
  /// The device sends a safety position word (BP3S) too.
  bool beside_safety = false;
};

namespace eds_detail {

template <class Report>
class Bp3Check {
 public:
  constexpr Bp3Check(const EdsBank& bank, const Bp3Context& context, const EdsCheckOptions& options,
                     const Report& report)
      : bank_(bank),
        part_(parse_bp3_part(bank)),
        id_{part_.bp_id},
        context_(context),
        options_(options),
        report_(report) {}

  constexpr void run() const {
    if (check_filling(bank_, "BP_VER", report_)) return;
    if (part_.bp_ver != 1) report_(EdsProblem::version, "BP_VER", part_.bp_ver, {}, 1);
    // The version row has the range 1…1 and would be reported twice.
    check_values(bank_, std::span(bp3_fields).subspan(1), options_, report_);
    check_polynomial();
    check_orders();
    const bool length_known = check_identifier();
    if (lengths_in_range()) check_counts(!length_known || check_lengths());
    check_sum(bank_, report_);
  }

 private:
  constexpr bool lengths_in_range() const {
    return part_.mt_len <= bp3_max_length_bits && part_.co_len <= bp3_max_length_bits &&
           part_.fi_len <= bp3_max_length_bits;
  }

  // True when DL can be held against the lengths.
  constexpr bool check_identifier() const {
    const std::uint32_t id = part_.bp_id;
    const auto bad = [&](EdsProblem problem, std::uint32_t expected = 0) {
      report_(problem, "BP_ID", id, {}, expected);
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
    const unsigned most = id_.crc_is_data() && options_.length_counts_crc
                              ? bp3_max_length_crc_is_data
                              : bp3_max_data_bits;
    if (id_.data_length() < bp3_min_data_bits || id_.data_length() > most) {
      return bad(EdsProblem::data_length);
    }
    if (context_.beside_safety && !id_.crc_is_data()) bad(EdsProblem::crc_bit);
    return true;
  }

  // DL as the lengths have it.
  constexpr unsigned data_length_of_parts() const {
    const bool counted = id_.crc_is_data() && options_.length_counts_crc;
    return part_.position_bits() + 2 + (counted ? crc6.width_bits : 0U);
  }

  constexpr bool check_lengths() const {
    const unsigned sum = data_length_of_parts();
    if (sum == id_.data_length()) return true;
    const std::string_view suspect = suspect_length(part_);
    const bool registers = context_.identifier.has_value();  // and they agree, or we were not here
    const bool outvoted = context_.dlen == sum;
    if (!registers && (outvoted || suspect.empty())) {
      report_(EdsProblem::lengths, "BP_ID", part_.bp_id, "FI_LEN", (part_.bp_id & 0xFF80U) | sum);
      return false;
    }
    const std::string_view symbol = suspect.empty() ? "FI_LEN" : suspect;
    const std::uint32_t value = symbol == "MT_LEN"   ? part_.mt_len
                                : symbol == "CO_LEN" ? part_.co_len
                                                     : part_.fi_len;
    const std::uint32_t expected = value + id_.data_length() - sum;
    report_(EdsProblem::lengths, symbol, value, "BP_ID", expected <= 57 ? expected : 0);
    return false;
  }

  // Only where the lengths hold: what follows from a wrong length is no finding of its own.
  constexpr void check_counts(bool lengths_hold) const {
    if (!lengths_hold || part_.en_typ > 1 || counts_of_type_fit(part_)) return;
    if (type_is_wrong()) {
      report_(EdsProblem::encoder_type, "EN_TYP", part_.en_typ, "MT_CNT", 1U - part_.en_typ);
      return;
    }
    if (part_.linear()) {
      check_pair("MT_CNT", part_.mt_cnt, part_.position_bits(), scale_fits);
      return;
    }
    if (!turns_fit(part_)) {
      const std::uint32_t swapped = bytes_swapped(part_.mt_cnt, 4);
      const bool order = swapped != 0 && counts_fit(swapped, part_.mt_len);
      report_(order ? EdsProblem::little_endian : EdsProblem::count_above_length, "MT_CNT",
              part_.mt_cnt, "MT_LEN", order ? swapped : part_.mt_len);
    }
    if (!periods_fit(part_)) {
      check_pair("SIP_CNT", part_.sip_cnt, unsigned{part_.co_len} + part_.fi_len, periods_fit);
    }
  }

  // With the other type everything fits, the checksum included; and no count with one byte changed
  // does as well.
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

  // A count times SIP_RES is too much for `bits`: is it the order of the bytes, or which is it?
  template <class Fits>
  constexpr void check_pair(std::string_view symbol, std::uint32_t count, unsigned bits,
                            Fits fits) const {
    const bool scale = symbol == "MT_CNT";
    const std::uint32_t count_swapped = bytes_swapped(count, 4);
    const std::uint32_t res_swapped = bytes_swapped(part_.sip_res, 4);
    const auto with = [&](std::uint32_t new_count, std::uint32_t new_res) {
      Bp3Part other = part_;
      (scale ? other.mt_cnt : other.sip_cnt) = new_count;
      other.sip_res = new_res;
      return fits(other);
    };
    const bool res_order = with(count, res_swapped);
    const bool count_order = with(count_swapped, part_.sip_res);
    const bool both = !res_order && !count_order && with(count_swapped, res_swapped);
    if (count_order || both) {
      report_(EdsProblem::little_endian, symbol, count, "SIP_RES", count_swapped);
    }
    if ((res_order && !count_order) || both) {
      report_(EdsProblem::little_endian, "SIP_RES", part_.sip_res, symbol, res_swapped);
    }
    if (res_order || count_order || both) return;
    const bool count_alone = !counts_fit(count_or_one(count), bits) ||
                             (!scale && part_.co_len != 0 && !counts_fit(count, part_.co_len));
    if (count_alone) {
      report_(EdsProblem::count_above_length, symbol, count, "SIP_RES", part_.sip_res);
    } else {
      report_(EdsProblem::count_above_length, "SIP_RES", part_.sip_res, symbol, count);
    }
  }

  constexpr void check_polynomial() const {
    const std::uint32_t stored = part_.cpoly;
    constexpr std::uint32_t due = crc6.polynomial >> 1U;
    if (stored == due) return;
    // Where nobody checks there need not be a polynomial.
    if (stored == 0 && id_.profile() == Profile::bp3 && id_.crc_is_data()) return;
    if (bytes_swapped(stored, 4) == due) {
      report_(EdsProblem::little_endian, "CPOLY", stored, {}, due);
    } else if (is_full_form_of_known(stored)) {
      report_(EdsProblem::polynomial_full_form, "CPOLY", stored, {}, stored >> 1U);
    } else {
      report_(EdsProblem::polynomial, "CPOLY", stored, {}, due);
    }
  }

  // No encoder works above this; with the bytes turned round it may be an ordinary temperature.
  static constexpr std::uint32_t plausible_kelvin_max = 1000;

  constexpr bool kelvin_swapped(std::string_view symbol, std::uint32_t value) const {
    const std::uint32_t swapped = bytes_swapped(value, 2);
    if (options_.absent(value, ones16) || value <= plausible_kelvin_max || swapped == 0 ||
        swapped > plausible_kelvin_max) {
      return false;
    }
    report_(EdsProblem::little_endian, symbol, value, {}, swapped);
    return true;
  }

  constexpr void check_orders() const {
    const bool low = kelvin_swapped("TMP_MIN", part_.tmp_min);
    const bool high = kelvin_swapped("TMP_MAX", part_.tmp_max);
    if (!low && !high) {
      check_order("TMP_MIN", part_.tmp_min, "TMP_MAX", part_.tmp_max, ones16, options_, report_);
    }
    check_order("VLT_MIN", part_.vlt_min, "VLT_MAX", part_.vlt_max, ones16, options_, report_);
  }

  const EdsBank& bank_;
  Bp3Part part_;
  ProfileIdentifier id_;
  const Bp3Context& context_;
  const EdsCheckOptions& options_;
  const Report& report_;
};

}  // namespace eds_detail

/// Reports all that is wrong with a BP3 part. A field is reported once; what merely follows from
/// another finding is not.
template <EdsSink Sink>
constexpr void check_bp3_part(const EdsBank& bank, Sink&& sink, const Bp3Context& context = {},
                              const EdsCheckOptions& options = {}) {
  const eds_detail::PartReport<std::remove_reference_t<Sink>> report{sink, EdsPart::bp3,
                                                                     context.channel};
  eds_detail::Bp3Check(bank, context, options, report).run();
}

}  // namespace biss
