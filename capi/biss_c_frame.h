/* Frames and SPI buffers, decoded and encoded; checksums. Units, levels, errors and lifetimes are
 * defined in biss_c.h.
 *
 *   Bits      bit 0 is the first on the line and the most significant bit of the first byte, as an
 *             SPI peripheral receives them. A bit is SLO once per clock of MA.
 *   Causes    a function that decodes returns BISS_OK when it was called correctly; frame->cause
 *             shows whether there is a frame.
 *   Threads   a biss_codec and a biss_spi do not change after init: any number of threads may
 *             use one at the same time. */
#pragma once

#include <biss_c.h>

BISS_C_BEGIN

/* ---- A frame format, prepared ---- */

/* A format with the tables that frames need; a biss_spi has its own. */
BISS_OBJECT(biss_codec, BISS_CODEC_WORDS);

/* BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING. */
biss_status biss_codec_init(biss_codec* codec, const biss_format* format);

/* ---- Frames ---- */

/* A frame, or the one cause why there is none. */
typedef struct biss_frame {
  biss_cause cause;
  uint32_t cause_channel; /* counts from 0; of BISS_CAUSE_CRC */
  /* All that follows is 0 unless `cause` is BISS_CAUSE_OK. */
  uint32_t channel_count;
  biss_channel channels[BISS_MAX_CHANNELS];
  bool cds;
  bool stop_seen;       /* the bits include STOP, which is then 0 */
  uint32_t lead_clocks; /* ones before ACK */
  uint32_t ack_clocks;  /* zeros of ACK */
  bool no_error_flag;   /* a position has no nE: nothing shows that it is wrong */
  bool unchecked;       /* a channel has no checksum: a disturbed one looks the same */
} biss_frame;

/* True: there is a frame, and no channel reports an error (nE), so its positions may be used. A
 * word of zeros has a right checksum; only nE shows that it holds no position. False for null, and
 * for a frame with `no_error_flag` or `unchecked`, which biss_spi_read() never sets: its setup has
 * the same words. */
bool biss_frame_trusted(const biss_frame* frame);

/* The bounds of the bits before the data. */
typedef struct biss_bounds {
  uint16_t lead_min_clocks; /* ones before ACK; 1 to 402 */
  uint16_t lead_max_clocks;
  uint16_t ack_min_clocks; /* zeros of ACK; 1 to 400 */
  uint16_t ack_max_clocks;
  uint16_t late_max_clocks; /* zeros in place of the first ones, for an encoder that is ready after
                               a fixed time; usually 0 */
} biss_bounds;

/* The widest that BiSS C allows at 10 MHz. */
biss_bounds biss_bounds_defaults(void);

/* Finds and decodes the frame in bits `first_bit` to `first_bit` + `bit_count` - 1 of `bytes`; bits
 * beyond the buffer do not exist, and bits after STOP are ignored. `bytes` may be null if
 * `byte_count` is 0. `bounds` may be null: biss_bounds_defaults(). Any cause. BISS_NULL_ARGUMENT,
 * BISS_BAD_HANDLE, BISS_BAD_FORMAT, BISS_BAD_SETUP: a bound is out of its range, or a minimum is
 * above its maximum. */
biss_status biss_frame_decode(const biss_codec* codec, const uint8_t* bytes, size_t byte_count,
                              size_t first_bit, size_t bit_count, const biss_bounds* bounds,
                              biss_frame* frame);

/* The bits that biss_frame_encode() writes at most, and the bytes they take. */
#define BISS_FRAME_BITS_MAX 1445
#define BISS_FRAME_BYTES_MAX 181

/* A frame to be encoded: the format's number of channels with position and counter 0 and neither
 * error nor warning, one leading one, one clock of ACK, CDS 0.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_frame_defaults(const biss_codec* codec, biss_frame* frame);

/* SLO once per clock of MA: `lead_clocks` ones, `ack_clocks` zeros, START, CDS, each channel with
 * its checksum, STOP. *bit_count is their number; the last byte is filled with zeros. `cause`,
 * `stop_seen`, `no_error_flag` and `unchecked` are ignored.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_BAD_FORMAT, BISS_CHANNEL_COUNT: not as in the format,
 * BISS_VALUE_RANGE: a position or counter is wider than its field, BISS_CLOCK_RANGE: `ack_clocks`
 * is not 1 to 400 or `lead_clocks` is above 402, BISS_NO_ROOM: `byte_count` is too small;
 * *bit_count is set and `bytes` unchanged. */
biss_status biss_frame_encode(const biss_codec* codec, const biss_frame* frame, uint8_t* bytes,
                              size_t byte_count, size_t* bit_count);

/* ---- SPI ---- */

BISS_OBJECT(biss_spi, BISS_CODEC_WORDS + 14);

typedef struct biss_spi_setup {
  const biss_format* format;
  int64_t period_ps;      /* of MA, 32 ps or more */
  bool sample_on_falling; /* CPHA = 0, mode 2; false: CPHA = 1, mode 3. CPOL is 1 */
  /* From MA to SLO, both at the master. The narrower, the more wrong frames are detected. */
  int64_t line_delay_min_ps;
  int64_t line_delay_max_ps; /* defaults: 40 us */
  uint32_t first_bit;        /* bits before the sample of the first clock, up to 65535 */
  bool ignore_tail;          /* for encoders that release SLO early; false: a 1 after STOP is
                                BISS_CAUSE_STOP_BIT while the encoder must keep SLO low */
  bool no_error_flag;        /* reads positions without nE too. biss_frame_trusted() is then true
                                for every good frame, also for a word of zeros */
  bool unchecked;            /* reads channels without checksum too: a disturbed one is then good */
} biss_spi_setup;

biss_spi_setup biss_spi_defaults(const biss_format* format, int64_t period_ps);

/* Makes a reader of the buffers of one encoder.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_BAD_SETUP, BISS_CLOCK_MAX,
 * BISS_NO_ERROR_FLAG, BISS_NO_CRC. */
biss_status biss_spi_init(biss_spi* spi, const biss_spi_setup* setup);

typedef struct biss_spi_size {
  size_t clocks; /* up to STOP, at the longest line delay and the longest ACK */
  size_t bytes;  /* to transfer for them, `first_bit` included */
  biss_bounds bounds;
} biss_spi_size;

/* BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_spi_size_of(const biss_spi* spi, biss_spi_size* size);

/* Finds and decodes the frame in the bytes that the peripheral received. Fill `bytes` with ones
 * before each transfer: if none of them is written, no frame of an earlier transfer is found.
 * `clocks` is how many clocks of MA were sent: later bits are ignored; SIZE_MAX: every bit from
 * `first_bit` on is a clock. Any cause. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_spi_read(const biss_spi* spi, const uint8_t* bytes, size_t byte_count,
                          size_t clocks, biss_frame* frame);

/* The line delays that fit a frame that this reader returned, from *min_ps to *max_ps.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_NO_READING: there is no frame, BISS_CLOCK_RANGE: fewer
 * leading ones than this reader returns. */
biss_status biss_spi_line_delay(const biss_spi* spi, const biss_frame* frame, int64_t* min_ps,
                                int64_t* max_ps);

/* ---- Turns ---- */

/* Counts the turns of an encoder that repeats after 2^width_bits counts. A step is taken in the
 * shorter direction: less than half a turn between two samples. */
BISS_OBJECT(biss_turns, 5);

typedef enum biss_turns_state BISS_INT {
  BISS_TURNS_EMPTY = 0, /* no sample yet */
  BISS_TURNS_FIRST,     /* one sample: no step was counted */
  BISS_TURNS_TRACKED,   /* every step since is known */
  BISS_TURNS_AMBIGUOUS  /* a step may have been either way, or turns passed unseen: until
                           biss_turns_resynchronise() or init */
} biss_turns_state;

typedef struct biss_turns_value {
  biss_turns_state state;
  int64_t turns; /* whole turns, negative below the start; an estimate if ambiguous */
  bool has_position;
  int64_t position; /* turns * 2^width_bits + the last sample; 0 without a sample, or if too wide */
} biss_turns_value;

/* `max_step` is the most counts from one sample to the next, which the highest speed gives; 0: just
 * below half a turn. A larger step makes the turns ambiguous.
 * BISS_NULL_ARGUMENT, BISS_BIT_COUNT: `width_bits` is not 1 to 64. */
biss_status biss_turns_init(biss_turns* turns, uint32_t width_bits, uint64_t max_step);

/* Takes a sample; bits above the width are dropped. `missed` is how many samples were missing or
 * bad since the last good one. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_turns_update(biss_turns* turns, uint64_t count, uint64_t missed,
                              biss_turns_value* value);

/* Sets the turns at the last sample, known from a reference; without a sample, at the first one.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_turns_resynchronise(biss_turns* turns, int64_t whole_turns,
                                     biss_turns_value* value);

/* The value as of the last call. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_turns_position(const biss_turns* turns, biss_turns_value* value);

/* ---- Checksums ---- */

/* The checksum that a BiSS master uses if only its width is given: start 0, inverted. For widths
 * other than 3 to 8 and 16 the polynomial is 0. */
biss_crc biss_crc_defaults(uint32_t width_bits);

/* The checksum of the lowest `bits` bits of `data`, 1 to 64, the most significant first, as
 * transmitted. BISS_NULL_ARGUMENT, BISS_BAD_CRC: no such checksum, or an error of a maker,
 * BISS_BIT_COUNT: `bits` is not 1 to 64, BISS_VALUE_RANGE: `data` has a 1 above them. */
biss_status biss_crc_of(const biss_crc* crc, uint64_t data, uint32_t bits, uint32_t* value);

BISS_C_END
