#include "device/words.hpp"

#include <array>

namespace biss {

namespace {

struct CauseText {
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array<CauseText, cause_count> causes{{
    {"healthy", "nothing to do"},
    {"wrong_format",
     "compare -f with the encoder's data sheet: bits, flags, CRC width, polynomial and start; look "
     "at the column raw of decode"},
    {"wrong_checksum",
     "correct the checksum in the encoder: polynomial in full form, start 0, over all data bits "
     "and flags but not CDS, inverted, highest bit first; docs/format.md has an example"},
    {"format_changes",
     "read each part with its own format: decode takes --since and --until; find out what changes "
     "the encoder's configuration"},
    {"ma_slo_swapped",
     "exchange --ma and --slo, or the probes; else the two pairs at the connector"},
    {"slo_inverted",
     "exchange the two wires of SLO, or put the probe on the other one; decode takes --invert-slo"},
    {"ma_inverted",
     "exchange the two wires of MA, or put the probe on the other one; decode takes --invert-ma"},
    {"clock_too_fast_for_cable",
     "lower the clock, shorten the cable, or use a master that compensates the line delay; biss "
     "plan prints the limits"},
    {"ack_longer_than_master_waits",
     "clock until START comes instead of a fixed number of clocks; biss plan prints how long ACK "
     "may be"},
    {"master_stops_early",
     "send more clocks: set the master to all bits of the frame; biss plan prints how many"},
    {"master_pauses_clock",
     "clock the whole frame without a pause: on an Arduino one SPI.transfer(buffer, size), not a "
     "call for each byte; on a Teensy, an ESP32 or an STM32 use SPI with DMA or its FIFO instead "
     "of polling, and no bit-banged clock; keep interrupts off until the frame is read"},
    {"requested_too_soon",
     "wait for the encoder's timeout: begin a request only when SLO is high; biss plan prints the "
     "shortest cycle"},
    {"noise_on_slo",
     "check the cable, the shield, the termination of SLO and the common ground; keep the cable "
     "away from motor cables"},
    {"noise_on_ma",
     "check the driver and the termination of MA, the ground and the threshold of the probe; keep "
     "the cable away from motor cables"},
    {"supply_or_intermittent",
     "check the encoder's supply under load, the connectors and the cable while it moves"},
    {"no_encoder",
     "check that the encoder has its supply, that MA reaches it, and that the probe is on SLO"},
    {"stuck_low",
     "look for a short circuit of SLO, exchanged wires of SLO, a missing supply or pull-up"},
    {"encoder_error",
     "clean the scale, check the installation of the readhead, the temperature and the speed; the "
     "error register of the encoder, if it has registers, has the reason"},
    {"frames_lost_or_repeated",
     "look for a part that stores frames between the encoder and this line, such as a converter or "
     "a repeater; compare the sign of life in -f with the encoder's data sheet"},
    {"position_implausible",
     "do not use the position at these places; check that the encoder latches turns and singleturn "
     "at the same moment, and that no other device answers on this line"},
    {"limits_exceeded",
     "keep the limits of the data sheet: biss check lists every rule with its limit"},
    {"sampling_too_slow",
     "record with at least 4 samples in a period of MA, better 10; give --resolution if the file "
     "does not have the sample period"},
    {"not_biss",
     "check which interface the device has, and whether both lines are connected; SSI, for "
     "example, has no ACK and no START"},
}};

constexpr std::string_view remedy(Cause cause) {
  return causes[static_cast<std::size_t>(cause)].remedy;
}

constexpr std::string_view wrong_type = "a wrong encoder type or limits, or a disturbed START";
constexpr std::string_view few_clocks = "too few clocks for this encoder";
constexpr std::string_view disturbed =
    "the frame was disturbed on the line, or the format is wrong";
constexpr std::string_view without_cds0 =
    "leave ;cds0 out of the format if the master uses registers";
constexpr std::string_view levels =
    "x or z on a line (reset, two drivers), or the capture, or the file of one line, ended there";

// In the order of CycleStatus.
constexpr auto statuses = std::to_array<StatusWords>({
    {.seen = "ACK, START, every checksum correct, STOP 0 if it was clocked"},
    {.seen = "SLO stayed high through the whole request",
     .failure = "SLO does not fall after the second rising edge of MA",
     .reason = "the encoder did not answer: supply, cable, MA",
     .remedy_of_some = remedy(Cause::supply_or_intermittent),
     .remedy_of_all = remedy(Cause::no_encoder)},
    {.seen = "SLO was low when the request began",
     .failure = "SLO is low when the request begins",
     .reason = "the request came too early, or SLO is stuck low",
     .remedy_of_some = remedy(Cause::requested_too_soon),
     .remedy_of_all = remedy(Cause::stuck_low)},
    {.seen = "SLO fell before the edge of MA that makes ACK, or more than 40 µs after it",
     .failure = "SLO falls later than any cable allows",
     .reason = wrong_type,
     .remedy_of_some = remedy(Cause::requested_too_soon),
     .remedy_of_all = remedy(Cause::not_biss)},
    {.seen = "ACK came, and SLO stayed low until MA stopped",
     .failure = "MA stops before START",
     .reason = few_clocks,
     .remedy_of_some = remedy(Cause::ack_longer_than_master_waits),
     .remedy_of_all = remedy(Cause::ack_longer_than_master_waits)},
    {.seen = "START came earlier or later than the bounds of the encoder allow",
     .failure = "ACK is not within the limits of the encoder",
     .reason = wrong_type,
     .remedy_of_some = remedy(Cause::noise_on_slo),
     .remedy_of_all = remedy(Cause::wrong_format)},
    {.seen = "MA stopped before the last CRC bit of the format",
     .failure = "MA stops before the last bit",
     .reason = few_clocks,
     .remedy_of_some = remedy(Cause::master_stops_early),
     .remedy_of_all = "a format with fewer bits, or more clocks from the master"},
    {.seen = "CDS was 1, but the format requires 0",
     .failure = "CDS is 1",
     .reason = disturbed,
     .remedy_of_some = without_cds0,
     .remedy_of_all = without_cds0},
    {.seen = "the checksum of a channel is wrong",
     .failure = "the checksum is wrong",
     .reason = disturbed,
     .remedy_of_some = remedy(Cause::noise_on_slo),
     .remedy_of_all = remedy(Cause::wrong_format)},
    {.seen = "every checksum is correct, and the bit after the last one is not 0",
     .failure = "STOP is 1",
     .reason = disturbed,
     .remedy_of_some = remedy(Cause::noise_on_slo),
     .remedy_of_all = remedy(Cause::wrong_format)},
    {.seen = "the capture begins inside this cycle",
     .failure = "the capture begins within this cycle"},
    {.seen = "the capture ends inside this cycle", .failure = "the capture ends within this cycle"},
    {.seen = "fewer than two rising edges of MA: a pulse and not a request",
     .failure = "MA has fewer than two rising edges, a pulse",
     .remedy_of_some = remedy(Cause::noise_on_ma),
     .remedy_of_all = remedy(Cause::noise_on_ma)},
    {.seen = "MA has an edge too few or too many inside the frame",
     .failure = "MA has an edge too few or too many",
     .remedy_of_some = remedy(Cause::noise_on_ma),
     .remedy_of_all = remedy(Cause::sampling_too_slow)},
    {.seen = "MA or SLO was neither 0 nor 1 while its level was needed",
     .failure = "MA or SLO is neither 0 nor 1",
     .remedy_of_some = levels,
     .remedy_of_all = levels},
    {.seen = "START was found; the format is not known, so that nothing else can be checked"},
});
static_assert(statuses.size() == cycle_status_count);

}  // namespace

std::string_view name_of(Cause cause) { return causes[static_cast<std::size_t>(cause)].name; }
std::string_view remedy_of(Cause cause) { return remedy(cause); }

const StatusWords& words_of(CycleStatus status) {
  return statuses[static_cast<std::size_t>(status)];
}

}  // namespace biss
