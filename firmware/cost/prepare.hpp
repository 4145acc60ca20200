// Prepares the samples: varied input, and the expected result of the measured call.
#pragma once

#include "firmware/cost/sample.hpp"
#include "tests/core/random.hpp"

namespace cost::prepare {

using Random = biss::test::Random;

/// A whole SPI buffer: random position, ACK 33…160 clocks, line delay 0…6 clocks.
void buffer(Sample& sample, Random& random);
/// A position to encode, and the ACK in `index`.
void position(Sample& sample, Random& random);
/// 28 bits for a CRC.
void crc(Sample& sample, Random& random);
/// Two ones, 33…160 zeros, a one.
void ack(Sample& sample, Random& random);
/// Random bytes and an index with 28 bits after it.
void word(Sample& sample, Random& random);

/// A counter with one sample; `value` has the next sample, across zero every other time.
void step(Sample& sample, Random& random);
/// The next cycle of an axis: a step, or one of 64 with a wrong CRC; `value` has the time.
void cycle(Sample& sample, Random& random);
/// A slave within its data; MA is high. `value` has the time of the next falling edge.
void data_bit(Sample& sample, Random& random);
/// A master within the data; MA is low. `value` has the time of the next rising edge, `index` has
/// SLO.
void data_sample(Sample& sample, Random& random);
/// A request by pins that has just begun, and its first byte.
void pins_byte(Sample& sample, Random& random);
/// A control session somewhere in an access; `value` has the time, `index` has CDS.
void control_frame(Sample& sample, Random& random);
/// A register server somewhere in an access; `index` has CDM.
void server_frame(Sample& sample, Random& random);
/// A safety monitor in the safe state and the next frame, which is good, damaged or hostile;
/// `value` has the time.
void safety_frame(Sample& sample, Random& random);

}  // namespace cost::prepare
