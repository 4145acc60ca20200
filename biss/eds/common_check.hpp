// Checks the common part of a data sheet: times, channels, and the banks of the channels' parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "biss/base/units.hpp"
#include "biss/crc/spec.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/part_check.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

namespace eds_detail {

template <EdsSink Sink>
class CommonCheck : PartCheck<Sink> {
  using Base = PartCheck<Sink>;
  using Base::report, Base::options_;

 public:
  constexpr CommonCheck(const EdsBank& checked, std::optional<std::uint8_t> eds_bank,
                        const EdsCheckOptions& given, Sink& sink)
      : Base(checked, EdsPart::common, 0, given, sink),
        part_(parse_common_part(checked)),
        eds_bank_(eds_bank) {}

  constexpr void run() const {
    if (this->check_filling("EDS_VER")) return;
    this->check_values(common_fields);
    order("TO_MIN", part_.to_min, "TO_MAX", part_.to_max);
    order("TOS_MIN", part_.tos_min, "TOS_MAX", part_.tos_max);
    order("TCLK_MIN", part_.tclk_min, "TCLK_MAX", part_.tclk_max);
    check_longest("TBUSY_MAX", part_.tbusy_max);
    if (part_.tma != 0 && rate_of(eds_time("TMA", part_.tma)) > biss_clock_max) {
      report(EdsProblem::out_of_range, "TMA", part_.tma);
    }
    if (part_.sl_num >= 1 && part_.sl_num <= 8 && part_.sl_off <= 7 &&
        part_.sl_off >= part_.sl_num) {
      report(EdsProblem::slave_offset, "SL_OFF", part_.sl_off, "SL_NUM", part_.sl_num);
    }
    if (options_.unnamed_zero && (part_.bc_off & 0xE0U) != 0) {
      report(EdsProblem::unnamed_not_zero, "BC_OFF", part_.bc_off);
    }
    if (part_.dc_num <= max_channels) {
      check_channels();
      check_banks();
    }
    this->check_sum();
  }

 private:
  constexpr void order(std::string_view low_symbol, std::uint8_t low, std::string_view high_symbol,
                       std::uint8_t high) const {
    this->check_order(low_symbol, low, high_symbol, high, 0xFF);
    check_longest(high_symbol, high);
  }

  // describe_device() uses no time that is longer than BiSS C allows.
  constexpr void check_longest(std::string_view symbol, std::uint8_t raw) const {
    static_assert(biss_busy_max == biss_static_timeout_max);
    if (options_.absent(raw, 0xFF) || eds_time(symbol, raw) <= biss_busy_max) return;
    report(EdsProblem::out_of_range, symbol, raw);
  }

  constexpr void check_channels() const {
    bool count_wrong = false;
    for (std::size_t i = 0; i < max_channels; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (i < part_.dc_num) {
        const bool missing = !is_given(channel.bank) && !is_given(channel.dlen) &&
                             !is_given(channel.format) && !is_given(channel.cpoly);
        count_wrong = count_wrong || missing;
        if (!missing) check_used(i, channel);
      } else if (is_given(channel.bank) && is_given(channel.dlen)) {
        count_wrong = true;
      } else {
        check_unused(i, channel);
      }
    }
    if (count_wrong) {
      report(EdsProblem::channel_count, "DC_NUM", part_.dc_num, {}, filled_channels());
    }
  }

  constexpr unsigned filled_channels() const {
    unsigned count = 0;
    for (const CommonChannel& channel : part_.channels) {
      if (is_given(channel.bank) || is_given(channel.dlen)) ++count;
    }
    return count;
  }

  constexpr void check_used(std::size_t i, const CommonChannel& channel) const {
    const auto& symbols = channel_symbols[i];
    if (channel.dlen == 0) report(EdsProblem::out_of_range, symbols[1], channel.dlen);
    if (options_.unnamed_zero && (channel.format & ~known_channel_format_bits) != 0) {
      report(EdsProblem::unnamed_not_zero, symbols[2], channel.format);
    }
    // 0 is checked in the profile's part: no CRC, or one too wide for this byte.
    if (channel.cpoly == 0) return;
    if (is_full_form_of_known(channel.cpoly)) {
      report(EdsProblem::polynomial_full_form, symbols[3], channel.cpoly, {}, channel.cpoly >> 1U);
    } else if (stored_crc_bits(channel.cpoly) < min_crc_bits) {
      report(EdsProblem::polynomial, symbols[3], channel.cpoly);
    }
  }

  constexpr void check_unused(std::size_t i, const CommonChannel& channel) const {
    const std::array bytes{channel.bank, channel.dlen, channel.format, channel.cpoly};
    for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
      // A length above 64 bits is already reported.
      if (!is_given(bytes[byte]) || (byte == 1 && bytes[byte] > max_data_bits)) continue;
      report(EdsProblem::channel_unused, channel_symbols[i][byte], bytes[byte], "DC_NUM",
             part_.dc_num);
    }
  }

  constexpr bool user_area_given() const {
    return !(part_.usr_sta == 0 && part_.usr_end == 0) &&
           !(part_.usr_sta == 0xFF && part_.usr_end == 0xFF);
  }
  constexpr bool in_user_area(unsigned bank) const {
    return user_area_given() && bank >= part_.usr_sta && bank <= part_.usr_end;
  }

  constexpr void check_banks() const {
    if (user_area_given() && part_.usr_sta > part_.usr_end) {
      report(EdsProblem::min_above_max, "USR_STA", part_.usr_sta, "USR_END", part_.usr_end);
    }
    unsigned parts = 0;
    unsigned outside = 0;
    for (std::size_t i = 0; i < part_.dc_num; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (channel.bank == 0 && channel.dlen == 0) continue;  // counted under DC_NUM or DLEN_i
      ++parts;
      if (is_outside(channel.bank)) ++outside;
    }
    // If every part lies outside, or there are fewer banks than parts, the length is wrong.
    const bool short_length = part_.eds_len != 0 && parts + 1 > part_.eds_len;
    const bool past_end = eds_bank_ && unsigned{*eds_bank_} + part_.eds_len > 256;
    if (short_length || past_end) {
      report(EdsProblem::too_few_banks, "EDS_LEN", part_.eds_len, {}, parts + 1);
    }
    for (std::size_t i = 0; i < part_.dc_num; ++i) check_bank(i, !short_length);
    if (eds_bank_ && in_user_area(*eds_bank_)) {
      report(EdsProblem::bank_in_user_area, "USR_STA", part_.usr_sta, {}, *eds_bank_);
    }
  }

  // Bank 0 holds no data sheet: EDS_BANK = 0 means none.
  constexpr bool is_outside(unsigned bank) const {
    if (bank == 0) return true;
    if (!eds_bank_ || part_.eds_len == 0) return false;
    return bank < *eds_bank_ || bank >= unsigned{*eds_bank_} + part_.eds_len;
  }

  constexpr void check_bank(std::size_t i, bool length_known) const {
    const unsigned bank = part_.channels[i].bank;
    const std::string_view symbol = channel_symbols[i][0];
    if (bank == 0 && part_.channels[i].dlen == 0) return;
    if (eds_bank_ && bank == *eds_bank_) {
      report(EdsProblem::bank_is_common, symbol, bank);
      return;
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (part_.channels[before].bank != bank) continue;
      report(EdsProblem::bank_shared, symbol, bank, channel_symbols[before][0], bank);
      return;
    }
    if (in_user_area(bank)) {
      report(EdsProblem::bank_in_user_area, symbol, bank, "USR_STA", part_.usr_sta);
    } else if (is_outside(bank) && (length_known || bank == 0)) {
      report(EdsProblem::bank_outside, symbol, bank, "EDS_LEN", part_.eds_len);
    }
  }

  CommonPart part_;
  std::optional<std::uint8_t> eds_bank_;
};

}  // namespace eds_detail

/// Reports all findings of a common part. With its bank (register 0x41), the banks of the channels
/// are checked, too.
template <EdsSink Sink>
constexpr void check_common_part(const EdsBank& bank, Sink&& sink,
                                 std::optional<std::uint8_t> eds_bank = {},
                                 const EdsCheckOptions& options = {}) {
  using PlainSink = std::remove_reference_t<Sink>;
  eds_detail::CommonCheck<PlainSink>(bank, eds_bank, options, sink).run();
}

}  // namespace biss
