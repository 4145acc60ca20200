// Valid input for the targets about registers: data sheets, and valid masters and encoders.
#pragma once

#include <random>

#include "biss/eds/advise.hpp"
#include "biss/eds/common_part.hpp"
#include "fuzz/target.hpp"

namespace biss::fuzz {

/// The banks of a good data sheet, common part first, then the banks of the channels.
inline std::vector<EdsBank> eds_banks_seed(std::uint64_t seed, std::uint8_t eds_bank) {
  std::mt19937_64 random(seed);
  const std::size_t channels = 1 + seed % 3;
  CommonPart common;
  common.eds_len = static_cast<std::uint8_t>(1 + channels);
  common.tma = static_cast<std::uint8_t>(100 + random() % 100);
  common.to_min = 50;
  common.to_max = static_cast<std::uint8_t>(60 + random() % 100);
  common.tos_max = static_cast<std::uint8_t>(random() % 200);
  common.tclk_max = static_cast<std::uint8_t>(random() % 2 * 20);
  common.tbusy_max = static_cast<std::uint8_t>(random() % 160);
  common.busy_s = static_cast<std::uint8_t>(random() % 9);
  common.pon_dly = 100;
  common.dc_num = static_cast<std::uint8_t>(channels);
  common.sl_num = static_cast<std::uint8_t>(channels);
  std::vector<EdsBank> banks(1);
  for (std::size_t i = 0; i < channels; ++i) {
    AdviceWish wish;
    wish.resolution_bits = static_cast<unsigned>(1 + random() % 30);
    wish.turns_bits = static_cast<unsigned>(random() % 25);
    wish.in_safety_encoder = seed % 8 == 7;
    const Advice advice = *advise(wish);
    common.channels[i] = {.bank = static_cast<std::uint8_t>(eds_bank + 1 + i),
                          .dlen = advice.channel.data_bits,
                          .cpoly = 0x21};
    banks.push_back(bp3_bank_of(advice));
  }
  banks[0] = sealed(build_bank(common));
  return banks;
}

inline void append_bank(std::string& input, const EdsBank& bank) {
  for (const std::uint8_t byte : bank) input += static_cast<char>(byte);
}

/// A complete data sheet and the registers that describe it.
inline std::string eds_seed(std::uint64_t seed) {
  constexpr char everything_and_sums = 0b000'11111;
  constexpr std::uint8_t eds_bank = 2;
  const std::vector<EdsBank> banks = eds_banks_seed(seed, eds_bank);
  const auto channels = static_cast<char>((1U << (banks.size() - 1)) - 1U);
  std::string input{everything_and_sums, channels, '\0', '\0', eds_bank, channels};
  for (std::size_t i = 1; i < banks.size(); ++i) {
    input += static_cast<char>(banks[i][2]);
    input += static_cast<char>(banks[i][3]);
  }
  for (const EdsBank& bank : banks) append_bank(input, bank);
  return input;
}

/// Three accesses of every kind; most answers of the encoder are right.
inline std::string session_seed(std::uint64_t seed) {
  constexpr char says_what_it_should = 3;
  std::mt19937_64 random(seed);
  std::string input;
  for (std::uint64_t i = 0; i < 3; ++i) {
    input += static_cast<char>((seed + i) % 12);
    input += static_cast<char>((seed + i) % 4 == 2 ? 1 : 0);
    input += static_cast<char>(random() % 64);
    input += static_cast<char>(1 + random() % 8);
    input += static_cast<char>(random() % 64);
    input += says_what_it_should;
    const std::uint64_t frames = random() % 60;
    for (std::uint64_t k = 0; k < frames; ++k) {
      const bool wrong = seed % 2 == 1 && random() % 32 == 0;
      input += static_cast<char>((random() % 4) << 2U | (wrong ? random() % 4 : 3));
    }
    if (frames != 0) input.append(8, static_cast<char>(says_what_it_should | 7 << 5));
  }
  return input;
}

/// Writes, reads and commands of a valid master with an occasional wrong bit.
inline std::string server_seed(std::uint64_t seed) {
  enum Op : unsigned { raw, zeros, access, command, choice, data, ones, device };
  std::mt19937_64 random(seed);
  std::string input;
  for (const unsigned limit : {256U, 16U, 1U, 128U}) input += static_cast<char>(random() % limit);
  const auto put = [&](Op op, unsigned how) { input += static_cast<char>(op | how << 3U); };
  for (int i = 0; i < 4; ++i) {
    put(zeros, 14);
    if (i == 0) put(device, 2);
    const auto slave = static_cast<unsigned>(random() % 2);
    if (random() % 4 == 0) {
      put(command, static_cast<unsigned>(random() % 4));
      input += static_cast<char>(random() % 8);
      put(ones, 1);
      put(zeros, 7);
      put(ones, 1);
      continue;
    }
    const bool write = random() % 2 == 0;
    put(access, slave);
    input += static_cast<char>(random() % 128);
    put(choice, write ? 0b011 : 0b101);
    for (int byte = 0; byte < 3; ++byte) {
      put(data, byte == 2 ? 0U : 1U);
      input += static_cast<char>(write ? random() % 256 : 0);
    }
    if (seed % 4 == 3) put(raw, static_cast<unsigned>(random() % 32));
  }
  return input;
}

/// Accesses of a valid master with occasional faults.
inline std::string listener_seed(std::uint64_t seed) {
  constexpr unsigned both_behave = 2 | 2 << 2U;
  std::mt19937_64 random(seed);
  std::string input;
  for (int i = 0; i < 8; ++i) {
    input += static_cast<char>(both_behave | (random() % 8) << 4U);
    if (seed % 2 == 1) input += static_cast<char>(random() % 16);
  }
  return input;
}

/// One to three devices with or without a data sheet; most answers are right.
inline std::string configure_seed(std::uint64_t seed) {
  constexpr char as_they_are = 3;
  constexpr std::array<unsigned, 4> one_two_three{0, 3, 5, 6};
  constexpr std::array<std::uint64_t, 4> devices{1, 2, 3, 2};
  std::mt19937_64 random(seed);
  std::string input{static_cast<char>(one_two_three[seed % 4] << 5U | (random() % 8) << 2U)};
  for (std::uint64_t i = 0; i < devices[seed % 4]; ++i) {
    constexpr unsigned no_changes_bank_named = 0x0F | 0x20;
    input += static_cast<char>(random() & random() & random() & no_changes_bank_named);
    const bool told = (input.back() & 0x20) != 0;
    input += static_cast<char>(random() % 16);
    input += static_cast<char>(random() & random() & 0x1FU);
    if (told) input += static_cast<char>(random() % 3);
  }
  input += as_they_are;
  const std::uint64_t runs = seed % 2 == 0 ? 0 : random() % 20;
  for (std::uint64_t i = 0; i < runs; ++i) {
    input += static_cast<char>(as_they_are | (random() % 10) << 3U);
    input += static_cast<char>(random() % 8);
  }
  return input;
}

}  // namespace biss::fuzz
