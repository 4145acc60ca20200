// EnDat 2.1 and 2.2: mode commands of the master, then words with a CRC of 5 bits.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "identify/protocol_pair.hpp"

namespace biss::identify {

namespace {

// How the levels become bits, and the CRC. EnDat sends it inverted; some encoders do not.
struct EndatReading {
  bool inverted = false;
  bool plain_crc = false;
};

// The CRC of EnDat: x^5 + x^3 + x + 1 over F1, F2 and the position, start 0x1F.
unsigned endat_crc(const std::vector<bool>& bits, std::size_t from, std::size_t count,
                   EndatReading reading) {
  unsigned crc = 0x1F;
  for (std::size_t i = from; i < from + count; ++i) {
    const bool out = (crc >> 4U & 1U) != 0;
    crc = (crc << 1U) & 0x1FU;
    if (out != (bits[i] != reading.inverted)) crc ^= 0x0BU;
  }
  return reading.plain_crc ? crc : ~crc & 0x1FU;
}

bool endat_crc_fits(const std::vector<bool>& bits, std::size_t from, std::size_t count,
                    EndatReading reading) {
  if (from + count + 5 > bits.size()) return false;
  const unsigned expected = endat_crc(bits, from, count, reading);
  unsigned received = 0;
  for (std::size_t i = from + count; i < from + count + 5; ++i) {
    received = received << 1U | (bits[i] != reading.inverted ? 1U : 0U);
  }
  return received == expected;
}

// The mode commands of EnDat 2.1 and 2.2, first bit first.
constexpr std::array<unsigned, 14> endat_modes{0x07, 0x0E, 0x1C, 0x23, 0x2A, 0x15, 0x31,
                                               0x38, 0x09, 0x1B, 0x24, 0x2D, 0x36, 0x12};

bool is_endat_mode(const std::vector<bool>& bits, std::size_t from, bool inverted) {
  if (from + 6 > bits.size()) return false;
  unsigned mode = 0;
  for (std::size_t i = from; i < from + 6; ++i) mode = mode << 1U | (bits[i] != inverted ? 1U : 0U);
  return std::find(endat_modes.begin(), endat_modes.end(), mode) != endat_modes.end();
}

// How well the transfers agree with one reading of EnDat.
struct EndatFit {
  double bits = 0;
  std::size_t position_bits = 0;
  std::size_t good = 0;
};

// The level of the data in each burst, `phase` periods after each return of the clock to idle.
std::vector<std::vector<bool>> bits_at(const Pair& pair, double phase, std::size_t most) {
  std::vector<std::vector<bool>> all;
  for (std::size_t i = 0; i < pair.transfers.size(); ++i) {
    const Burst& burst = pair.shape->bursts[i];
    std::vector<bool> bits;
    for (std::size_t k = 0; k < std::min(burst.pulses(), most); ++k) {
      bits.push_back(pair.data.level_at(later(return_of(pair, burst, k), phase * pair.period())));
    }
    all.push_back(std::move(bits));
  }
  return all;
}

// The master changes its bits at one edge of the clock or the other, without a delay.
double endat_mode_share(const Pair& pair, bool inverted) {
  double best = 0;
  for (const double phase : {-0.05, 0.2, 0.45}) {
    const auto all = bits_at(pair, phase, 10);
    for (const std::size_t from : {1U, 2U, 3U}) {
      const auto legal = std::count_if(all.begin(), all.end(), [&](const std::vector<bool>& bits) {
        return is_endat_mode(bits, from, inverted);
      });
      best = std::max(best, static_cast<double>(legal) / static_cast<double>(all.size()));
    }
  }
  return best;
}

using BitWords = std::vector<std::vector<bool>>;

// What the encoder sends after its START, the first 1 after the bits of the master.
BitWords encoder_words(const Pair& pair, bool inverted, double phase) {
  BitWords words;
  for (std::vector<bool>& bits : bits_at(pair, phase + 0.5, pulses_used)) {
    std::size_t start = 9;
    while (start < bits.size() && bits[start] == inverted) ++start;
    if (start + 1 >= bits.size()) continue;
    bits.erase(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(start + 1));
    words.push_back(std::move(bits));
  }
  return words;
}

// F1, F2 and position of `count` bits, then the CRC. Only words that differ up to there count. The
// clocks end with the CRC, or with that of additional information: START, 24 bits, CRC.
EndatFit fit_of_count(const BitWords& words, std::size_t length_bits, std::size_t count,
                      EndatReading reading) {
  std::set<std::vector<bool>> good;
  std::size_t fitting = 0;
  for (const auto& word : words) {
    if (!endat_crc_fits(word, 0, count, reading)) continue;
    ++fitting;
    good.insert({word.begin(), word.begin() + static_cast<std::ptrdiff_t>(count + 5)});
  }
  if (10 * fitting < 7 * words.size()) return {};
  const std::size_t rest = length_bits - count - 5;
  const bool all_used = rest % 30 <= 1 && rest <= 61;
  double bits = 5 * static_cast<double>(good.size()) - (all_used ? 2.5 : 5.5);
  for (std::size_t more = 0; all_used && more < rest / 30; ++more) {
    const std::size_t from = count + 5 + 30 * more + 1;
    const auto fits = std::count_if(words.begin(), words.end(), [&](const auto& each) {
      return endat_crc_fits(each, from, 24, reading);
    });
    bits += 10 * static_cast<std::size_t>(fits) >= 7 * words.size() ? 5 : -5;
  }
  return {bits, count, fitting};
}

EndatFit fit_endat(const Pair& pair, bool inverted, double phase) {
  const BitWords words = encoder_words(pair, inverted, phase);
  EndatFit best;
  if (words.size() < 2) return best;
  std::size_t length_bits = 0;
  for (const auto& word : words) length_bits = std::max(length_bits, word.size());
  for (std::size_t count = 9; count <= 52 && count + 5 <= length_bits; ++count) {
    for (const bool plain_crc : {false, true}) {
      const EndatFit fit = fit_of_count(words, length_bits, count, {inverted, plain_crc});
      if (fit.bits > best.bits) best = fit;
    }
  }
  return best;
}

// Data rests at the level at which the clock does not, and returns there from the other one a fixed
// time after the last clock: the recovery time of 1.25 us to 3.75 us, or of 10 us to 30 us.
bool has_recovery(const Pair& pair) {
  const bool rest = !pair.shape->idle_high;
  std::vector<double> times;
  std::size_t resting = 0;
  for (std::size_t i = 1; i < pair.transfers.size(); ++i) {
    if (pair.transfers[i].before != rest) continue;
    ++resting;
    const Picoseconds next = later(pair.transfers[i].begin, -0.1 * pair.period());
    const std::size_t at = pair.data.after(next);
    const Picoseconds end = pair.transfers[i - 1].end;
    if (at != 0 && pair.data.changes[at - 1] > end) {
      times.push_back(length(end, pair.data.changes[at - 1]));
    }
  }
  constexpr double microsecond = 1e6;
  const double usual = median_of(times);
  const bool legal = usual > 1.0 * microsecond && usual < 35 * microsecond;
  const double steady = share_near_median(times, 0.15 * usual + 2 * pair.period() / 8);
  return 10 * resting >= 9 * (pair.transfers.size() - 1) && 10 * times.size() >= 9 * resting &&
         legal && steady > 0.85;
}

}  // namespace

ProtocolGuess try_endat(const Pair& pair) {
  ProtocolGuess guess = guess_of(Protocol::endat22, pair, 0, "");
  if (usual_pulses(pair.shape->bursts) < 24 || pair.transfers.size() < 2) return guess;
  const double recovery_bits = has_recovery(pair) ? 5 : 0;
  for (const bool inverted : {false, true}) {
    const double modes = endat_mode_share(pair, inverted);
    if (modes < 0.8) continue;
    EndatFit best;
    for (const double phase : {pair.phase, 0.0, 0.25, 0.5, -0.25}) {
      const EndatFit fit = fit_endat(pair, inverted, phase);
      if (fit.bits > best.bits) best = fit;
    }
    if (best.bits > 0 || recovery_bits != 0) best.bits += recovery_bits;
    const double confidence = best.bits >= 14  ? 0.97
                              : best.bits >= 7 ? 0.85
                              : best.bits > 2  ? 0.6
                                               : 0.1;
    if (confidence <= guess.confidence) continue;
    guess.confidence = confidence * modes;
    guess.why = fmt::format(
        "{:.0f} % of the bursts begin with a mode command, and the CRC x^5+x^3+x+1 fits {} words "
        "after {} bits",
        100 * modes, best.good, best.position_bits);
  }
  return guess;
}

}  // namespace biss::identify
