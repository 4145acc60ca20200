#include "tests/timing/scenario.hpp"

#include <algorithm>

#include "biss/frame/format_text.hpp"

namespace timing_test {

namespace {

using biss::Picoseconds;

struct Owner {
  const CoreSlave* slave = nullptr;
  oracle::SlaveAnswer* log = nullptr;
  const Picoseconds* now = nullptr;

  biss::Frame sample(Picoseconds moment) const {
    log->samples.push_back(moment.count);
    return slave->frame(log->samples.size() - 1);
  }
  bool cds(bool predecessor) const { return predecessor || slave->cds; }
  void cdm(bool bit) const { log->cdm.push_back({now->count, bit}); }
};

using Codec = biss::FrameCodec<biss::CrcBitwise>;
using Slave = biss::Slave<Codec, Owner>;

biss::TimeoutRule rule_of(oracle::TimeoutKind kind) {
  if (kind == oracle::TimeoutKind::adaptive) return biss::TimeoutRule::adaptive;
  return kind == oracle::TimeoutKind::fixed ? biss::TimeoutRule::fixed : biss::TimeoutRule::cycle;
}

biss::SlaveTiming timing_of(const oracle::SlaveDescription& slave) {
  return {.sampling = Picoseconds{slave.sampling},
          .start_min = Picoseconds{slave.start_min},
          .ready = Picoseconds{slave.ready},
          .ack_clocks = static_cast<std::uint16_t>(slave.ack_clocks),
          .busy_s_clocks = static_cast<std::uint8_t>(slave.busy_clocks),
          .timeout = {rule_of(slave.kind), Picoseconds{slave.timeout},
                      static_cast<std::uint8_t>(slave.release_halves)},
          .static_timeout = Picoseconds{slave.static_timeout},
          .chained = slave.chained};
}

// The daisy chain of the core's slaves; a change passes through it without delay.
class Chain {
 public:
  explicit Chain(const std::vector<CoreSlave>& slaves)
      : answers_(slaves.size()), outputs_(slaves.size()) {
    for (std::size_t k = 0; k < slaves.size(); ++k) {
      slaves_.emplace_back(Codec(slaves[k].format), slaves[k].timing,
                           Owner{&slaves[k], &answers_[k], &now_});
    }
  }

  void step(Picoseconds now, bool ma) {
    now_ = now;
    bool sli = false;
    for (std::size_t k = 0; k < slaves_.size(); ++k) {
      const bool before = outputs_[k].level;
      outputs_[k] = slaves_[k].step(now, ma, sli);
      sli = outputs_[k].level;
      if (sli != before) answers_[k].slo.push_back({now.count, sli});
    }
  }

  Picoseconds deadline() const {
    Picoseconds least = biss::never;
    for (const auto& output : outputs_) least = std::min(least, output.deadline);
    return least;
  }
  Answers answers() const { return answers_; }

 private:
  Picoseconds now_{};
  Answers answers_;
  std::vector<Slave> slaves_;
  std::vector<biss::StepOutput> outputs_;
};

oracle::Checksum checksum_of(unsigned bits) {
  const std::uint64_t polynomial = bits == 3 ? 0b1011 : 0b1000011;
  return {oracle::bits_of(polynomial, bits + 1U), oracle::Bits(bits, false), true};
}

std::string at(const char* what, std::size_t k, const std::string& a, const std::string& b) {
  return std::string(what) + " of slave " + std::to_string(k) + ":\n  " + a + "\n  " + b + "\n";
}

std::string text_of(const std::vector<oracle::Time>& times) {
  oracle::Line line;
  for (const oracle::Time time : times) line.push_back({time, true});
  return timing_test::text_of(line);
}

}  // namespace

Answers answers_of_core(const std::vector<CoreSlave>& slaves, const oracle::Line& edges) {
  Chain chain(slaves);
  bool ma = true;
  const auto run_until = [&](Picoseconds end) {
    while (chain.deadline() < end) chain.step(chain.deadline(), ma);
  };
  for (const oracle::Change& edge : edges) {
    run_until(Picoseconds{edge.time});
    ma = edge.level;
    chain.step(Picoseconds{edge.time}, ma);
  }
  run_until(biss::never);
  return chain.answers();
}

Answers answers_of_core(const Scenario& scenario) {
  std::vector<CoreSlave> slaves;
  for (const Device& device : scenario.chain) {
    const std::string format =
        "pos" + std::to_string(device.position_bits) + ",crc" + std::to_string(device.crc_bits);
    const auto frame = [&device](std::size_t number) {
      biss::Frame sent;
      sent.channel_list[0].position = device.position ^ (number & device.changing);
      return sent;
    };
    slaves.push_back(
        {biss::parse_format(format).value(), timing_of(device.timing), frame, device.cds});
  }
  return answers_of_core(slaves, scenario.ma);
}

Answers answers_of_oracle(const Scenario& scenario) {
  Answers answers;
  oracle::Line sli;
  for (const Device& device : scenario.chain) {
    const auto payload = [&](std::size_t number) {
      oracle::Bits bits =
          oracle::bits_of(device.position ^ (number & device.changing), device.position_bits);
      const oracle::Bits sum = oracle::checksum_of(checksum_of(device.crc_bits), bits);
      bits.insert(bits.end(), sum.begin(), sum.end());
      return bits;
    };
    answers.push_back(oracle::answer(device.timing, scenario.ma, sli, payload, device.cds));
    sli = answers.back().slo;
  }
  return answers;
}

std::string difference(const Answers& first, const Answers& second) {
  if (first.size() != second.size()) return "a different number of slaves";
  for (std::size_t k = 0; k < first.size(); ++k) {
    const oracle::SlaveAnswer& a = first[k];
    const oracle::SlaveAnswer& b = second[k];
    if (a.slo != b.slo) return at("SLO", k, text_of(a.slo), text_of(b.slo));
    if (a.samples != b.samples) return at("sampling", k, text_of(a.samples), text_of(b.samples));
    if (a.cdm != b.cdm) return at("CDM", k, text_of(a.cdm), text_of(b.cdm));
  }
  return {};
}

std::string text_of(const oracle::Line& line) {
  std::string text;
  for (const oracle::Change& change : line) {
    std::string picoseconds = std::to_string(change.time % 1000);
    picoseconds.insert(0, 3 - picoseconds.size(), '0');
    text += " " + std::to_string(change.time / 1000);
    if (change.time % 1000 != 0) text += "." + picoseconds;
    text += change.level ? "^" : "_";
  }
  return text;
}

}  // namespace timing_test
