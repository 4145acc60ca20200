// What can be told wrong about a common part.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "biss/eds/bank.hpp"
#include "biss/eds/check_field.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/finding.hpp"

namespace biss {
namespace eds_detail {

// 0 and 0xFF: nothing was filled in.
constexpr bool is_empty(std::uint8_t byte) { return byte == 0x00 || byte == 0xFF; }

template <class Report>
class CommonCheck {
 public:
  constexpr CommonCheck(const EdsBank& bank, std::optional<std::uint8_t> eds_bank,
                        const EdsCheckOptions& options, const Report& report)
      : bank_(bank),
        part_(parse_common_part(bank)),
        eds_bank_(eds_bank),
        options_(options),
        report_(report) {}

  constexpr void run() const {
    if (check_filling(bank_, "EDS_VER", report_)) return;
    check_values(bank_, common_fields, options_, report_);
    order("TO_MIN", part_.to_min, "TO_MAX", part_.to_max);
    order("TOS_MIN", part_.tos_min, "TOS_MAX", part_.tos_max);
    order("TCLK_MIN", part_.tclk_min, "TCLK_MAX", part_.tclk_max);
    if (part_.sl_num >= 1 && part_.sl_num <= 8 && part_.sl_off <= 7 &&
        part_.sl_off >= part_.sl_num) {
      report_(EdsProblem::slave_offset, "SL_OFF", part_.sl_off, "SL_NUM", part_.sl_num);
    }
    if (options_.unnamed_zero && (part_.bc_off & 0xE0U) != 0) {
      report_(EdsProblem::unnamed_not_zero, "BC_OFF", part_.bc_off);
    }
    if (part_.dc_num <= max_channels) {
      check_channels();
      check_banks();
    }
    check_sum(bank_, report_);
  }

 private:
  constexpr void order(std::string_view low_symbol, std::uint8_t low, std::string_view high_symbol,
                       std::uint8_t high) const {
    check_order(low_symbol, low, high_symbol, high, 0xFF, options_, report_);
  }

  constexpr void check_channels() const {
    bool count_wrong = false;
    for (std::size_t i = 0; i < max_channels; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (i < part_.dc_num) {
        const bool missing = is_empty(channel.bank) && is_empty(channel.dlen) &&
                             is_empty(channel.format) && is_empty(channel.cpoly);
        count_wrong = count_wrong || missing;
        if (!missing) check_used(i, channel);
      } else if (!is_empty(channel.bank) && !is_empty(channel.dlen)) {
        count_wrong = true;
      } else {
        check_unused(i, channel);
      }
    }
    if (count_wrong) {
      report_(EdsProblem::channel_count, "DC_NUM", part_.dc_num, {}, filled_channels());
    }
  }

  constexpr unsigned filled_channels() const {
    unsigned count = 0;
    for (const CommonChannel& channel : part_.channels) {
      if (!is_empty(channel.bank) || !is_empty(channel.dlen)) ++count;
    }
    return count;
  }

  constexpr void check_used(std::size_t i, const CommonChannel& channel) const {
    const auto& symbols = channel_symbols[i];
    if (channel.dlen == 0) report_(EdsProblem::out_of_range, symbols[1], channel.dlen);
    if (options_.unnamed_zero && (channel.format & ~known_channel_format_bits) != 0) {
      report_(EdsProblem::unnamed_not_zero, symbols[2], channel.format);
    }
    // 0 is left to the profile's part: no CRC, or one too wide for this byte.
    if (channel.cpoly == 0) return;
    if (is_full_form_of_known(channel.cpoly)) {
      report_(EdsProblem::polynomial_full_form, symbols[3], channel.cpoly, {}, channel.cpoly >> 1U);
    } else if (stored_crc_bits(channel.cpoly) < min_crc_bits) {
      report_(EdsProblem::polynomial, symbols[3], channel.cpoly);
    }
  }

  constexpr void check_unused(std::size_t i, const CommonChannel& channel) const {
    const std::array bytes{channel.bank, channel.dlen, channel.format, channel.cpoly};
    for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
      // A length beyond 64 bits was reported already.
      if (is_empty(bytes[byte]) || (byte == 1 && bytes[byte] > max_data_bits)) continue;
      report_(EdsProblem::channel_unused, channel_symbols[i][byte], bytes[byte], "DC_NUM",
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
      report_(EdsProblem::min_above_max, "USR_STA", part_.usr_sta, "USR_END", part_.usr_end);
    }
    unsigned parts = 0;
    unsigned outside = 0;
    for (std::size_t i = 0; i < part_.dc_num; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (channel.bank == 0 && channel.dlen == 0) continue;  // counted under DC_NUM or DLEN_i
      ++parts;
      if (is_outside(channel.bank)) ++outside;
    }
    // Where each part lies outside, or fewer banks than parts, it is the length that is wrong.
    const bool short_length = part_.eds_len != 0 && parts + 1 > part_.eds_len;
    const bool past_end = eds_bank_ && unsigned{*eds_bank_} + part_.eds_len > 256;
    if (short_length || past_end) {
      report_(EdsProblem::too_few_banks, "EDS_LEN", part_.eds_len, {}, parts + 1);
    }
    for (std::size_t i = 0; i < part_.dc_num; ++i) check_bank(i, !short_length);
    if (eds_bank_ && in_user_area(*eds_bank_)) {
      report_(EdsProblem::bank_in_user_area, "USR_STA", part_.usr_sta, {}, *eds_bank_);
    }
  }

  // Bank 0 holds no data sheet: EDS_BANK = 0 says that there is none.
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
      report_(EdsProblem::bank_is_common, symbol, bank);
      return;
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (part_.channels[before].bank != bank) continue;
      report_(EdsProblem::bank_shared, symbol, bank, channel_symbols[before][0], bank);
      return;
    }
    if (in_user_area(bank)) {
      report_(EdsProblem::bank_in_user_area, symbol, bank, "USR_STA", part_.usr_sta);
    } else if (is_outside(bank) && (length_known || bank == 0)) {
      report_(EdsProblem::bank_outside, symbol, bank, "EDS_LEN", part_.eds_len);
    }
  }

  const EdsBank& bank_;
  CommonPart part_;
  std::optional<std::uint8_t> eds_bank_;
  const EdsCheckOptions& options_;
  const Report& report_;
};

}  // namespace eds_detail

/// Reports all that is wrong with a common part. With the bank it stands in (register 0x41) the
/// banks of the channels are judged too.
template <EdsSink Sink>
constexpr void check_common_part(const EdsBank& bank, Sink&& sink,
                                 std::optional<std::uint8_t> eds_bank = {},
                                 const EdsCheckOptions& options = {}) {
  const eds_detail::PartReport<std::remove_reference_t<Sink>> report{sink};
  eds_detail::CommonCheck(bank, eds_bank, options, report).run();
}

}  // namespace biss
