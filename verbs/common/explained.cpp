#include "verbs/common/explained.hpp"

#include "identify/protocol.hpp"

namespace biss::verbs {

namespace {

// The format that the frames show; the given format if both judge every frame in the same way.
std::optional<explain::IdentifiedFormat> identified_format(const DecodedCapture& capture) {
  const auto* finding = capture.finding();
  const auto* sure = finding != nullptr ? finding->sure() : nullptr;
  if (sure == nullptr) return std::nullopt;
  if (capture.better_format() != nullptr || !capture.format()) {
    return explain::IdentifiedFormat{sure->format, sure->confidence};
  }
  return explain::IdentifiedFormat{*capture.format(), sure->confidence};
}

// Another protocol than BiSS C that these lines carry.
std::optional<explain::OtherProtocol> other_protocol(DecodedCapture& capture) {
  const identify::ProtocolGuess guess = capture.protocol();
  using enum identify::Protocol;
  switch (guess.protocol) {
    case biss_c:
    case unknown:
    case idle:
    case clock_alone:
      return std::nullopt;
    default:
      return explain::OtherProtocol{std::string(name_of(guess.protocol)), guess.confidence,
                                    guess.why};
  }
}

// Sees the changes of the capture, too.
class WatchingObserver final : public explain::Observer, public flow::ChangeWatcher {
 public:
  using explain::Observer::Observer;

  void take(std::span<const wire::Edge> edges) override {
    settle();
    Observer::take(edges);
  }
  void take(const capture::PairPiece& changes) override {
    Observer::take(decode::PairRun{.ma = {changes.ma.times, changes.ma.first_high},
                                   .slo = {changes.slo.times, changes.slo.first_high}});
    settle();
  }
};

}  // namespace

explain::Reading choose_reading(DecodedCapture& capture) {
  decode::Lines lines = capture.lines().lines;
  lines.ma_inverted = capture.arguments().invert_ma;
  lines.slo_inverted = capture.arguments().invert_slo;
  explain::Reading reading = explain::choose_reading(lines, capture.beginning(), capture.reader());
  // Lines without names cannot have the wrong ones.
  const bool named = capture.lines().origin != decode::LineOrigin::by_behaviour;
  reading.swapped = reading.swapped && named;
  return reading;
}

bool observe(DecodedCapture& capture, const decode::Lines& lines,
             const std::function<void(const decode::Cycle& cycle)>& on_cycle,
             explain::Evidence& evidence) {
  WatchingObserver observer({.format = capture.format(),
                             .timing = capture.timing(),
                             .timeout = capture.reader().timing().timeout,
                             .margin = capture.margin(),
                             .lines = lines},
                            capture.beginning());
  capture.read_as(lines);
  const auto take = [&](std::uint64_t number, const decode::Cycle& cycle) {
    on_cycle(cycle);
    observer.add(number, cycle);
    return true;
  };
  const bool whole = capture.read(take, &observer);
  evidence = observer.finish(capture.end_time());
  return whole;
}

explain::Context explain_context(DecodedCapture& capture) {
  explain::Context context;
  context.format = capture.format();
  context.given = !capture.arguments().device.format.empty();
  context.timing = capture.timing();
  if (capture.arguments().no_compensation) context.compensated = false;
  context.reading = choose_reading(capture);
  context.identified = identified_format(capture);
  if (const auto* finding = capture.finding(); finding != nullptr && !context.identified) {
    for (const auto& each : finding->candidates) context.candidates.push_back(each.format);
  }
  context.format_parts = capture.format_parts();
  context.other = other_protocol(capture);
  return context;
}

}  // namespace biss::verbs
