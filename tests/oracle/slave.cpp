#include "tests/oracle/slave.hpp"

#include <algorithm>

namespace oracle {

namespace {

constexpr Time forever = 9'000'000'000'000'000'000;

// The level from `time` on; a change at exactly that time counts.
bool level_at(const Line& line, Time time) {
  bool level = true;
  for (const Change& change : line) {
    if (change.time > time) break;
    level = change.level;
  }
  return level;
}

Time first_rise_after(const Line& line, Time time) {
  for (const Change& change : line) {
    if (change.time > time && change.level) return change.time;
  }
  return forever;
}

// One request: the edges of MA that belong to it, and the results of their number.
class Request {
 public:
  Request(const SlaveDescription& slave, const Line& sli, Time begin)
      : slave_(slave), sli_(sli), begin_(begin), cycle_begin_(begin) {}

  void falling(Time time) {
    paused_ = rising_.size() >= 2 && time - last_ > reference();
    last_ = time;
    if (!slave_.chained || rising_.size() < 2) return;
    const bool bit = level_at(sli_, time);
    if (start_heard_) {
      heard_.push_back(bit);
    } else if (bit && zero_heard_) {
      start_heard_ = true;
    } else if (!bit) {
      zero_heard_ = true;
    }
  }

  // SLO after this edge.
  bool rising(Time time, const std::function<Bits()>& payload, bool cds) {
    rising_.push_back(time);
    const Time fell = last_;
    last_ = time;
    const std::size_t number = rising_.size();
    if (number == 1) return true;
    if (number == 2) return false;
    if (!given_up_ && start_ == 0) {
      if (can_start(time)) start_ = number;
      return start_ != 0;
    }
    if (!given_up_ && number == start_ + 1) return next_heard() || cds;
    if (!given_up_) {
      const Bits bits = payload();
      const std::size_t index = number - start_ - 2;
      if (index < bits.size()) return bits[index];
      if (paused_ && index > bits.size()) cycle_begin_ = fell;
    } else if (paused_) {
      cycle_begin_ = fell;
    }
    return next_heard();
  }

  // The end of the slave's own timeout if no further edge comes.
  Time end() const {
    const bool measured = rising_.size() >= 2;
    switch (slave_.kind) {
      case TimeoutKind::fixed:
        return last_ + slave_.timeout;
      case TimeoutKind::adaptive:
        if (!measured) return last_ + slave_.static_timeout;
        return last_ + std::min(reference() + slave_.timeout, slave_.static_timeout);
      case TimeoutKind::cycle:
        return std::max(
            cycle_begin_ + slave_.timeout,
            last_ + (measured ? reference() + reference() / 3 * (slave_.release_halves - 3) : 0));
    }
    return forever;
  }

  // A new request came before the predecessors were ready.
  void give_up(Time time) {
    given_up_ = true;
    cycle_begin_ = time;
  }

  bool latched() const { return !rising_.empty(); }
  bool acknowledged() const { return rising_.size() >= 2; }
  Time sampling_moment() const { return rising_.front() + slave_.sampling; }

 private:
  // One and a half periods.
  Time reference() const { return std::min(rising_[1] - begin_, slave_.static_timeout); }

  bool can_start(Time time) {
    if (time < sampling_moment()) return false;
    if (slave_.ack_clocks != 0) {
      if (rising_.size() < 2 + slave_.ack_clocks) return false;
    } else if (time < rising_[0] + slave_.start_min || time < rising_[1] + slave_.ready) {
      return false;
    }
    if (slave_.chained && !start_heard_) return false;
    return ++possible_ > slave_.busy_clocks;
  }

  bool next_heard() {
    if (passed_on_ >= heard_.size()) return false;
    return heard_[passed_on_++];
  }

  const SlaveDescription& slave_;
  const Line& sli_;
  Time begin_;
  Time cycle_begin_;
  Time last_ = 0;
  std::vector<Time> rising_;
  std::size_t start_ = 0;     // the number of START's rising edge, from 1
  std::size_t possible_ = 0;  // rising edges at which START could have come
  bool zero_heard_ = false;
  bool start_heard_ = false;
  Bits heard_;
  std::size_t passed_on_ = 0;
  bool paused_ = false;
  bool given_up_ = false;
};

void put(Line& slo, Time time, bool level) {
  const bool before = slo.empty() || slo.back().level;
  if (before != level) slo.push_back({time, level});
}

class Reader {
 public:
  Reader(const SlaveDescription& slave, const Line& ma, const Line& sli, const PayloadOf& payload,
         bool cds)
      : slave_(slave), ma_(ma), sli_(sli), payload_(payload), cds_(cds) {}

  SlaveAnswer read() {
    std::size_t at = 0;
    while (at < ma_.size()) {
      at = ma_[at].level ? at + 1 : request(at);
    }
    return result_;
  }

 private:
  // The request that begins with edge `at`; the number of the first edge after it.
  std::size_t request(std::size_t at) {
    Request request(slave_, sli_, ma_[at].time);
    sampled_.reset();
    at = edges(request, at, true);
    if (request.acknowledged()) result_.cdm.push_back({request.end(), !ma_[at - 1].level});
    while (slave_.chained && request.acknowledged() && !level_at(sli_, request.end())) {
      put(result_.slo, request.end(), false);
      const Time all_ready = first_rise_after(sli_, request.end());
      while (time_of(at) < all_ready && ma_[at].level) ++at;
      if (time_of(at) >= all_ready) {
        if (all_ready != forever) put(result_.slo, all_ready, true);
        return at;
      }
      request.give_up(ma_[at].time);
      at = edges(request, at, false);
    }
    put(result_.slo, request.end(), true);
    return at;
  }

  // Reads edges until the slave's own timeout is over.
  std::size_t edges(Request& request, std::size_t at, bool may_sample) {
    do {
      const Change edge = ma_[at++];
      if (edge.level) {
        const auto payload = [&] { return payload_(*sampled_); };
        put(result_.slo, edge.time, request.rising(edge.time, payload, cds_));
      } else {
        request.falling(edge.time);
      }
      if (may_sample && !sampled_ && request.latched() &&
          request.sampling_moment() <= std::min(time_of(at), request.end())) {
        sampled_ = result_.samples.size();
        result_.samples.push_back(request.sampling_moment());
      }
    } while (time_of(at) < request.end());
    return at;
  }

  Time time_of(std::size_t at) const { return at < ma_.size() ? ma_[at].time : forever; }

  const SlaveDescription& slave_;
  const Line& ma_;
  const Line& sli_;
  const PayloadOf& payload_;
  bool cds_;
  std::optional<std::size_t> sampled_;  // the number of this request's sampling
  SlaveAnswer result_;
};

}  // namespace

SlaveAnswer answer(const SlaveDescription& slave, const Line& ma, const Line& sli,
                   const PayloadOf& payload, bool cds) {
  return Reader(slave, ma, sli, payload, cds).read();
}

}  // namespace oracle
