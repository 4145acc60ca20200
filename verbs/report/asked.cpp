#include "verbs/report/asked.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace biss::verbs {

void AskedVerb::open(const DecodedCapture& reading) { status_ = begin(reading); }

ExitStatus AskedVerb::begin(const DecodedCapture& reading) {
  DecodedCapture& capture = run_->capture();
  ended_ = true;
  const ExitStatus opened = run_->open();
  if (opened != ExitStatus::done) return opened;
  if (!capture.next()) return capture.status();
  if (const auto status = run_->begin(*writer_, messages_)) return *status;
  ended_ = false;
  const decode::Lines& own = capture.lines().lines;
  const decode::Lines& read = reading.lines().lines;
  if (own.ma != read.ma || own.slo != read.slo) return ExitStatus::done;
  if (run_->watcher() != nullptr) capture.watch(*run_->watcher());
  shares_ = capture.reads_as(reading);
  if (!shares_) {
    following_.emplace(capture, [this](std::uint64_t number, const decode::Cycle& cycle) {
      run_->take(number, cycle);
      return true;
    });
  }
  return ExitStatus::done;
}

void AskedVerb::take(std::uint64_t number, const decode::Cycle& cycle) {
  if (!shares_) return;
  run_->capture().follow(number, cycle, [this](std::uint64_t place, const decode::Cycle& each) {
    run_->take(place, each);
    return true;
  });
}

void AskedVerb::end(Picoseconds end_time) {
  DecodedCapture& capture = run_->capture();
  if (shares_ || following_) {
    if (shares_) capture.end_following();
    if (following_) following_->finish(end_time);
    status_ = run_->end(true, end_time, *writer_, messages_);
    capture.unwatch();
  } else if (!ended_) {
    status_ = run_->judge(*writer_, messages_);
  }
  while (status_ < ExitStatus::usage && capture.next()) {
    status_ = std::max(status_, run_->judge(*writer_, messages_));
  }
  status_ = std::max(status_, capture.status());
}

tl::expected<nlohmann::json, VerbError> AskedVerb::answer(Picoseconds end_time) {
  if (status_ < ExitStatus::usage) end(end_time);
  writer_->finish();
  messages_.print(host_);
  if (status_ >= ExitStatus::usage) {
    return tl::unexpected(VerbError{
        status_, name_ + ": " + (host_.lines().empty() ? "no message" : host_.lines().back())});
  }
  return nlohmann::json{
      {"status", static_cast<int>(status_)}, {"out", out_.text()}, {"err", host_.text()}};
}

}  // namespace biss::verbs
