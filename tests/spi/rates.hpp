// Computes the rate of accepted damaged transfers from the exact shares of lab/test_slip.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>

#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "lab/test_slip.hpp"

namespace biss::test::spi {

/// A frame as the encoder sent it, and the checks of the reader.
struct Transfer {
  unsigned lead_clocks = 2;
  unsigned ack_clocks = 1;
  /// The number of samples of the reader.
  std::size_t clocks = 0;
  FrameBounds bounds{};
};

/// Rates of one format under one model. Every channel must have a CRC: then a single wrong bit
/// after CDS is always seen and only a wrong START can pass.
class Rates {
 public:
  Rates(const FrameFormat& format, const lab::SlipModel& model) : format_(format), model_(model) {}

  /// Share of transfers accepted although START was read as 0.
  double lost_start(const Transfer& transfer) const {
    return late(transfer, transfer.lead_clocks, transfer.ack_clocks, 0);
  }

  /// Share of transfers accepted with a wrong START although the one sample at `index` is inverted.
  double flipped(const Transfer& transfer, std::size_t index) const {
    const int start = static_cast<int>(transfer.lead_clocks + transfer.ack_clocks);
    const int at = static_cast<int>(index);
    if (at == 0 || at > start) return 0;
    if (at == start) return lost_start(transfer);
    const int lead = static_cast<int>(transfer.lead_clocks);
    // After a 0 among the leading ones, the next sample is 1 and looks like START.
    if (at < lead - 1) return seen(transfer, at, 1) ? share(at + 1 - start, transfer, 0) : 0;
    if (at == lead - 1) return 0;
    if (at > lead) return seen(transfer, lead, at - lead) ? share(at - start, transfer, 0) : 0;
    if (transfer.ack_clocks > 1) return 0;
    return lost_ack(transfer);
  }

  /// Mean of flipped() over the ACK bits.
  double flipped_ack(const Transfer& transfer) const {
    double sum = 0;
    for (unsigned i = 0; i < transfer.ack_clocks; ++i) {
      sum += flipped(transfer, transfer.lead_clocks + i);
    }
    return sum / transfer.ack_clocks;
  }

 private:
  static bool seen(const Transfer& transfer, int lead, int ack) {
    const FrameBounds& bounds = transfer.bounds;
    return lead >= bounds.lead_min_clocks && lead <= bounds.lead_max_clocks &&
           ack >= bounds.ack_min_clocks && ack <= bounds.ack_max_clocks;
  }

  // The only ACK bit is 1: the leading ones continue through START and the ones after it.
  double lost_ack(const Transfer& transfer) const {
    double sum = 0;
    for (unsigned ones = 0; ones <= payload_and_cds(); ++ones) {
      sum += late(transfer, transfer.lead_clocks + 2 + ones, 0, ones);
    }
    return sum;
  }

  double late(const Transfer& transfer, unsigned lead, unsigned zeros, unsigned ones) const {
    double sum = 0;
    const bool ack_left = zeros > 0;
    for (unsigned place = ones + (ack_left ? 1 : 2); place <= payload_and_cds(); ++place) {
      const unsigned ack = ack_left ? zeros + place : place - 1 - ones;
      const std::size_t last_crc =
          transfer.lead_clocks + transfer.ack_clocks + place + payload_and_cds();
      if (last_crc >= transfer.clocks) break;
      if (!seen(transfer, static_cast<int>(lead), static_cast<int>(ack))) continue;
      sum += share(static_cast<int>(place), transfer, ones);
    }
    return sum;
  }

  unsigned payload_and_cds() const { return format_.payload_bits() + 1; }

  double share(int place, const Transfer& transfer, unsigned ones) const {
    // The length of ACK affects only a START before it.
    const bool in_front = -place > static_cast<int>(transfer.ack_clocks);
    const unsigned ack = in_front ? transfer.ack_clocks : max_ack;
    const auto [found, fresh] = known_.try_emplace({place, ack, ones});
    if (fresh) {
      found->second = lab::slip_conditions(format_,
                                           {.place = place,
                                            .ack_clocks = static_cast<std::uint16_t>(ack),
                                            .ones_clocks = static_cast<std::uint16_t>(ones)},
                                           model_);
    }
    return found->second ? std::ldexp(1.0, -static_cast<int>(*found->second)) : 0;
  }

  static constexpr unsigned max_ack = FrameBounds{}.ack_max_clocks + 1U;

  FrameFormat format_;
  lab::SlipModel model_;
  mutable std::map<std::tuple<int, unsigned, unsigned>, std::optional<unsigned>> known_;
};

}  // namespace biss::test::spi
