// biss_safety: the core's SafetyMonitor.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/safety/plan.hpp"
#include "capi/biss_c_safety.h"
#include "capi/frame.hpp"

namespace biss::capi {

namespace {

using Plan = SafetyPlan<max_channels>;
using Monitor = SafetyMonitor<Plan>;

static_assert(BISS_VERDICT_INVALID == safety_verdict_count);
static_assert(index_of(SafetyVerdict::stimulus) == BISS_VERDICT_STIMULUS);
static_assert(index_of(SafetyVerdict::watchdog) == BISS_VERDICT_WATCHDOG);
static_assert(index_of(SafetyVerdict::comparison) == BISS_VERDICT_COMPARISON);
static_assert(BISS_COUNT_LEARNED == static_cast<int>(CounterMode::learned));
static_assert(BISS_ANY_COUNTER == any_first_value);

biss_safety_setup as_setup(const biss_format* format, const SafetySetup& from) {
  return {.format = format,
          .cpw = from.cpw,
          .spw = from.spw,
          .start_frames = from.start_frames,
          .latch = from.latch,
          .compare_bits = from.comparison.compare_bits,
          .tolerance_lsb = from.comparison.tolerance_lsb,
          .ignore_turns = from.comparison.multiturn == MultiturnRule::ignored,
          .counter = static_cast<biss_counter_mode>(from.counter.mode),
          .perhaps_missed = from.counter.missed == MissedFrames::perhaps,
          .near_frames = from.counter.near_frames,
          .learn_rollovers = from.counter.learn_rollovers,
          .counter_first = from.counter.first,
          .cycle_min_ps = from.cycle_min.count,
          .frame_gap_max_ps = from.frame_gap_max.count,
          .frame_gap_min_ps = from.frame_gap_min.count,
          .clock_tolerance_ps = from.clocks.tolerance.count,
          .still_requests = from.clocks.still_requests,
          .bit_period_ps = from.clocks.bit_period.count,
          .budget_faults = from.budget.faults,
          .budget_window_ps = from.budget.window.count,
          .bounds = std::bit_cast<biss_bounds>(from.bounds),
          .residual_max_e15 = from.residual_max_e15,
          .rating_words = from.rating.words,
          .rating_residual_e24 = from.rating.residual_e24,
          .rating_check = from.rating.check,
          .unrated = false};
}

// check_safety() judges the values; here only that each fits its field.
bool is_possible(const biss_safety_setup& setup) {
  for (const std::uint32_t number :
       {setup.cpw, setup.spw, setup.start_frames, setup.compare_bits, setup.tolerance_lsb,
        setup.near_frames, setup.learn_rollovers, setup.counter_first, setup.still_requests,
        setup.budget_faults}) {
    if (number > UINT8_MAX) return false;
  }
  return setup.counter >= BISS_COUNT_1_63 && setup.counter <= BISS_COUNT_LEARNED;
}

std::uint8_t byte(std::uint32_t number) { return static_cast<std::uint8_t>(number); }

// \pre is_possible()
SafetySetup from_c(const biss_safety_setup& from) {
  SafetySetup setup{.cpw = byte(from.cpw),
                    .spw = byte(from.spw),
                    .start_frames = byte(from.start_frames),
                    .latch = from.latch};
  setup.comparison = {byte(from.compare_bits), byte(from.tolerance_lsb),
                      from.ignore_turns ? MultiturnRule::ignored : MultiturnRule::with_carry};
  setup.counter = {static_cast<CounterMode>(from.counter),
                   from.perhaps_missed ? MissedFrames::perhaps : MissedFrames::counted,
                   byte(from.near_frames), byte(from.learn_rollovers), byte(from.counter_first)};
  setup.cycle_min = picoseconds(from.cycle_min_ps);
  setup.frame_gap_max = picoseconds(from.frame_gap_max_ps);
  setup.frame_gap_min = picoseconds(from.frame_gap_min_ps);
  setup.clocks = {picoseconds(from.clock_tolerance_ps), byte(from.still_requests),
                  picoseconds(from.bit_period_ps)};
  setup.budget = {byte(from.budget_faults), picoseconds(from.budget_window_ps)};
  setup.bounds = std::bit_cast<FrameBounds>(from.bounds);
  setup.residual_max_e15 = from.residual_max_e15;
  setup.rating = {from.rating_words, from.rating_residual_e24, from.rating_check};
  return setup;
}

struct Wanted {
  biss_status status = BISS_OK;
  FrameFormat format{};
  SafetySetup setup{};
  bool unrated = false;
  /// Why these frames cannot be monitored: BISS_BAD_SAFETY.
  std::optional<SafetySetupError> mistake{};
};

Wanted read_setup(const biss_safety_setup* setup) {
  if (setup == nullptr) return {.status = BISS_NULL_ARGUMENT};
  Described device;
  if (const auto wrong = read(setup->format, device)) return {.status = wrong};
  if (!is_possible(*setup)) return {.status = BISS_BAD_SETUP};
  Wanted wanted{.format = device.format, .setup = from_c(*setup), .unrated = setup->unrated};
  wanted.mistake = setup->unrated ? check_safety(wanted.format, UnratedSafetySetup(wanted.setup))
                                  : check_safety(wanted.format, wanted.setup);
  if (wanted.mistake) wanted.status = BISS_BAD_SAFETY;
  return wanted;
}

TwoClocks from_c(const biss_safety_time& time) {
  return {picoseconds(time.now_ps), picoseconds(time.second_ps),
          Transfer{picoseconds(time.transfer_ps), 0}};
}

biss_judgement as_judgement(const Monitor& monitor, const SafetyJudgement& from) {
  const GuardedPosition& position = from.position;
  const std::uint64_t none = from.verdict == SafetyVerdict::safe ? BISS_NO_POSITION : 0;
  return {.verdict = static_cast<biss_verdict>(index_of(from.verdict)),
          .state = name_of(from.state).data(),
          .tolerated = from.tolerated,
          .cpw_nW = from.cpw_nW,
          .spw_nW = from.spw_nW,
          .life_counter = from.life_counter,
          .difference_lsb = from.difference_lsb,
          .has_position = position.has_value(),
          .position = position ? position->value : none,
          .low = position ? position->low : none,
          .high = position ? position->high : none,
          .control_position = position ? control_position(monitor.plan(), *position) : none};
}

Plan plan_of(const Wanted& wanted) {
  if (wanted.unrated) return Plan(wanted.format, UnratedSafetySetup(wanted.setup));
  return Plan(wanted.format, wanted.setup);
}

biss_status put_setup(const biss_format* format, const SafetySetup& usual, std::int64_t cycle_ps,
                      biss_safety_setup* setup) {
  if (format == nullptr || setup == nullptr) return BISS_NULL_ARGUMENT;
  if (cycle_ps < 0) return BISS_BAD_SETUP;
  *setup = as_setup(format, cycle_ps == 0 ? usual : at_cycle(usual, picoseconds(cycle_ps)));
  return BISS_OK;
}

}  // namespace

}  // namespace biss::capi

using namespace biss::capi;

extern "C" {

biss_status biss_safety_defaults(const biss_format* format, int64_t cycle_ps,
                                 biss_safety_setup* setup) {
  return put_setup(format, biss::SafetySetup{}, cycle_ps, setup);
}

const char* biss_safety_problem(const biss_safety_setup* setup) {
  const auto wanted = read_setup(setup);
  return wanted.mistake ? biss::name_of(*wanted.mistake).data() : nullptr;
}

biss_status biss_safety_parse(const char* text, int64_t cycle_ps, biss_format* format,
                              biss_safety_setup* setup) {
  if (text == nullptr) return BISS_NULL_ARGUMENT;
  const biss::SafetyConfiguration* found = biss::find_safety_configuration(text);
  const auto wrong =
      put_setup(format, found == nullptr ? biss::SafetySetup{} : found->setup, cycle_ps, setup);
  return wrong == BISS_OK ? biss_format_parse(text, format) : wrong;
}

biss_status biss_safety_init(biss_safety* safety, const biss_safety_setup* setup) {
  if (const auto wrong = begin_init(safety)) return wrong;
  const auto wanted = read_setup(setup);
  return wanted.status == BISS_OK ? make<Monitor>(safety, plan_of(wanted)) : wanted.status;
}

biss_status biss_safety_self_test(biss_safety* safety, const biss_safety_setup* expected,
                                  bool* passed) {
  if (passed == nullptr) return BISS_NULL_ARGUMENT;
  *passed = false;
  if (const auto wrong = check_call(safety)) return wrong;
  const auto wanted = read_setup(expected);
  if (wanted.status != BISS_OK) return wanted.status;
  *passed = thing<Monitor>(safety).self_test(
      biss::SafetyFingerprint(wanted.format, wanted.setup, wanted.unrated ? 0 : 1));
  return BISS_OK;
}

const char* biss_verdict_name(biss_verdict verdict) {
  const bool known = verdict >= BISS_VERDICT_SAFE && verdict < BISS_VERDICT_INVALID;
  return known ? biss::name_of(biss::verdict_of(static_cast<std::size_t>(verdict))).data()
               : "invalid";
}

biss_status biss_safety_step(biss_safety* safety, const biss_safety_time* time,
                             const uint8_t* bytes, size_t byte_count, size_t first_bit,
                             size_t bit_count, biss_judgement* judgement) {
  if (const auto wrong = check_call(safety, time, judgement, given(bytes, byte_count)))
    return wrong;
  const biss::BitView bits(std::span(bytes, byte_count), first_bit, bit_count);
  *judgement =
      as_judgement(thing<Monitor>(safety), thing<Monitor>(safety).step(from_c(*time), bits));
  return BISS_OK;
}

biss_status biss_safety_watch(biss_safety* safety, const biss_safety_time* time,
                              biss_judgement* judgement) {
  if (const auto wrong = check_call(safety, time, judgement)) return wrong;
  *judgement = as_judgement(thing<Monitor>(safety), thing<Monitor>(safety).watch(from_c(*time)));
  return BISS_OK;
}

biss_status biss_safety_deadline(const biss_safety* safety, bool* is_expected,
                                 int64_t* deadline_ps) {
  if (const auto wrong = check_call(safety, is_expected, deadline_ps)) return wrong;
  const auto deadline = thing<Monitor>(safety).deadline();
  *is_expected = deadline.has_value();
  *deadline_ps = deadline ? deadline->count : BISS_NEVER;
  return BISS_OK;
}

biss_status biss_safety_expect(biss_safety* safety, uint64_t low, uint64_t high) {
  if (const auto wrong = check_call(safety)) return wrong;
  thing<Monitor>(safety).expect_position(low, high);
  return BISS_OK;
}

biss_status biss_safety_acknowledge(biss_safety* safety, biss_verdict cause) {
  if (const auto wrong = check_call(safety)) return wrong;
  if (cause < BISS_VERDICT_SAFE || cause >= BISS_VERDICT_INVALID) return BISS_NO_READING;
  const auto verdict = biss::verdict_of(static_cast<std::size_t>(cause));
  return thing<Monitor>(safety).acknowledge(verdict) ? BISS_OK : BISS_NO_READING;
}

biss_status biss_safety_cause(const biss_safety* safety, biss_verdict* cause) {
  if (const auto wrong = check_call(safety, cause)) return wrong;
  const biss::SafetyState state = thing<Monitor>(safety).state();
  if (state != biss::SafetyState::latched && state != biss::SafetyState::failed) {
    return BISS_NO_READING;
  }
  *cause = static_cast<biss_verdict>(biss::index_of(thing<Monitor>(safety).latched_cause()));
  return BISS_OK;
}

biss_status biss_safety_encoder_restarted(biss_safety* safety) {
  if (const auto wrong = check_call(safety)) return wrong;
  thing<Monitor>(safety).encoder_restarted();
  return BISS_OK;
}

}  // extern "C"
