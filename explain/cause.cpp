#include "explain/cause.hpp"

namespace biss::explain {

namespace {

struct CauseText {
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array<CauseText, cause_count> texts{{
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
     "leave the encoder its timeout: begin a request only when SLO is high; biss plan prints the "
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
     "look for what stores frames between the encoder and this line, such as a converter or a "
     "repeater; compare the sign of life in -f with the encoder's data sheet"},
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

}  // namespace

std::string_view name_of(Cause cause) { return texts[static_cast<std::size_t>(cause)].name; }
std::string_view remedy_of(Cause cause) { return texts[static_cast<std::size_t>(cause)].remedy; }

}  // namespace biss::explain
