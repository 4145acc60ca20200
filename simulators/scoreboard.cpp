#include "simulators/scoreboard.hpp"

#include <fmt/format.h>

#include <utility>

namespace biss::simulators {

void Scoreboard::sent(const Outcome& outcome) {
  if (waiting_.size() == waiting_max) {
    add(waiting_.front(), "frame", waiting_.front().cause, "not read");
    waiting_.pop_front();
  }
  waiting_.push_back(outcome);
}

bool Scoreboard::read(const Outcome& outcome) {
  const std::uint64_t before = mismatches_;
  if (waiting_.empty()) {
    add(outcome, "frame", "nothing", outcome.cause);
    return false;
  }
  const Outcome sent = waiting_.front();
  waiting_.pop_front();
  ++compared_;
  const bool some_fault = outcome.cause == "fault" && sent.cause != "ok";
  if (outcome.cause != sent.cause && !some_fault) {
    add(sent, "cause", sent.cause, outcome.cause);
  } else if (sent.cause == "ok") {
    for (std::size_t k = 0; k < format_.channel_count; ++k) compare_channel(sent, outcome, k);
  }
  return mismatches_ == before;
}

void Scoreboard::compare_channel(const Outcome& sent, const Outcome& read, std::size_t channel) {
  const Value& a = sent.values[channel];
  const Value& b = read.values[channel];
  const auto name = [&](const char* what) {
    return fmt::format("{} of channel {}", what, channel);
  };
  if (!a.given || !b.given) {
    add(sent, name("values"), a.given ? "given" : "missing", b.given ? "given" : "missing");
    return;
  }
  const bool known = a.known && b.known;
  if (!known || a.channel.position != b.channel.position) {
    const auto text = [](const Value& value) {
      return value.known ? fmt::format("0x{:X}", value.channel.position) : "unknown bits";
    };
    add(sent, name("position"), text(a), text(b));
  }
  const ChannelFormat& format = format_.channel_list[channel];
  const auto flag = [&](bool present, const char* what, bool first, bool second) {
    if (!present || first == second) return;
    add(sent, name(what), first ? "1" : "0", second ? "1" : "0");
  };
  flag(format.error.present, "nE", a.channel.nE, b.channel.nE);
  flag(format.warning.present, "nW", a.channel.nW, b.channel.nW);
}

void Scoreboard::withdraw(std::uint64_t request) {
  if (!waiting_.empty() && waiting_.back().request == request) waiting_.pop_back();
}

void Scoreboard::fail_waiting() {
  for (const Outcome& outcome : waiting_) add(outcome, "frame", outcome.cause, "not reported");
  waiting_.clear();
}

void Scoreboard::broken(std::uint64_t request, std::int64_t time_ps, std::string rule,
                        std::string limit, std::string seen) {
  Outcome outcome;
  outcome.request = request;
  outcome.time_ps = time_ps;
  add(outcome, std::move(rule), std::move(limit), std::move(seen));
}

void Scoreboard::add(const Outcome& outcome, std::string what, std::string sent, std::string read) {
  ++mismatches_;
  if (listed_.size() == listed_max) return;
  listed_.push_back(
      {outcome.request, outcome.time_ps, std::move(what), std::move(sent), std::move(read)});
}

}  // namespace biss::simulators
