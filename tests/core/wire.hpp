// A master, a cable, and the device at its end.
#pragma once

#include "biss/base/units.hpp"
#include "biss/master/request.hpp"
#include "biss/timing/step.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/test.hpp"

namespace biss::test {

/// A daisy chain of slaves as one device; slave 0 is at the far end.
template <class AnySlave, std::size_t Count>
struct Row {
  std::array<AnySlave, Count> slaves;

  StepOutput step(Picoseconds now, bool ma) {
    StepOutput all{.level = false};
    for (AnySlave& slave : slaves) {
      const StepOutput one = slave.step(now, ma, all.level);
      all = {one.level, std::min(one.deadline, all.deadline)};
    }
    return all;
  }
};

/// `Device` has `StepOutput step(now, ma)`.
template <class Master, class Device, class Delay = DelayLine>
struct Wire {
  Master master;
  Device device;
  Delay way_out;
  Delay way_back;
  /// A fixed level of SLO at the master, for a broken wire.
  std::optional<bool> stuck{};
  Picoseconds now{};
  StepOutput driven{};
  StepOutput answered{};
  /// MA of the last request, as it left the master.
  std::uint32_t rises = 0;
  std::uint32_t falls = 0;
  Picoseconds last_edge{};
  Picoseconds shortest = never;

  bool slo() { return stuck.value_or(way_back.level(now)); }
  void step(Picoseconds time) {
    now = time;
    step_device();
    drive(master.step(now, slo()));
    step_device();
  }
  Picoseconds next() const {
    return std::min(std::min(driven.deadline, answered.deadline),
                    std::min(way_out.next(), way_back.next()));
  }
  void rest_until(Picoseconds time) {
    while (next() < time) step(next());
    now = std::max(now, time);
  }
  /// Makes a request at the earliest permitted time, not before `at`.
  const auto& request(RequestKind kind = RequestKind::frame, bool cdm = false,
                      Picoseconds at = {}) {
    return request_with(kind, cdm, at, [cdm](bool) { return cdm; });
  }
  /// The same, but `answer(cds)` returns another CDM as soon as CDS was received.
  template <class Answer>
  const auto& request_with(RequestKind kind, bool cdm, Picoseconds at, Answer answer) {
    rest_until(std::max({now, master.earliest(), at}));
    step_device();
    rises = falls = 0;
    shortest = never;
    drive(master.begin(now, slo(), cdm, kind));
    bool answered_cds = false;
    for (std::uint32_t i = 0; i < 100'000 && !master.done(); ++i) {
      step(next());
      if (answered_cds || master.done() || !master.reading().cds) continue;
      answered_cds = true;
      master.set_cdm(answer(*master.reading().cds));
    }
    BISS_EXPECT(master.done());
    return master.reading();
  }

 private:
  void step_device() {
    answered = device.step(now, way_out.level(now));
    way_back.put(now, answered.level);
  }
  void drive(StepOutput output) {
    if (output.level != driven.level) {
      if (rises + falls != 0) shortest = std::min(shortest, now - last_edge);
      ++(output.level ? rises : falls);
      last_edge = now;
    }
    driven = output;
    way_out.put(now, driven.level);
  }
};

}  // namespace biss::test
