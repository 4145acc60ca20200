/* Frames and SPI buffers, decoded and encoded; checksums. Units, levels, errors and lifetimes are
 * defined in biss_c.h.
 *
 *   Bits      bit 0 is the first on the line and the most significant bit of the first byte, as an
 *             SPI peripheral receives them. A bit is SLO once per clock of MA.
 *   Causes    a function that decodes returns BISS_OK when it was called correctly; frame->cause
 *             shows whether there is a frame.
 *   Threads   a biss_format and a biss_spi do not change after open: any number of threads may
 *             use one at the same time. */
#pragma once

#include <biss_c.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A frame format, prepared ---- */

typedef struct biss_format biss_format;

/* `text` is a catalogue name or a format, as everywhere. Its tables take about 33 KiB. *format is
 * null unless BISS_OK. BISS_NULL_ARGUMENT, BISS_NO_MEMORY, BISS_BAD_FORMAT. */
biss_status biss_format_open(const char* text, biss_format** format);

/* Null is allowed. A biss_spi that was opened with it remains valid. */
void biss_format_close(biss_format* format);

/* A checksum, as data. */
typedef struct biss_crc {
  uint32_t polynomial; /* in full form, with the top and the lowest term: 0x43 = x^6 + x + 1 */
  uint32_t start;      /* of the register, at most 2^width_bits - 1 */
  uint32_t width_bits; /* 3 to 16; 0 in a biss_channel_format: no checksum */
  bool inverted;       /* sent with every bit inverted, as BiSS does */
  /* Errors of an encoder's maker, which formats have as suffixes: bits reversed, without nE and nW,
   * CDS covered too, of the frame before. All false for biss_crc_of(). */
  bool reversed;
  bool without_flags;
  bool with_cds;
  bool of_previous;
} biss_crc;

/* One data channel. A width of 0: the channel has no such field. */
typedef struct biss_channel_format {
  uint32_t data_bits;       /* 1 to 64, without the checksum */
  uint32_t position_bits;   /* of biss_channel.position, turns included */
  uint32_t singleturn_bits; /* its lower bits; 0: turns are not a field of their own */
  uint32_t life_counter_bits;
  bool has_error; /* nE or E; false: nE is always true */
  bool has_warning;
  biss_crc crc;
} biss_channel_format;

/* Channel `index`, from 0 in the order on the line.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_CHANNEL_COUNT: there is no such channel. */
biss_status biss_format_channel(const biss_format* format, size_t index, biss_channel_format* out);

typedef struct biss_format_size {
  uint32_t channel_count;
  uint32_t payload_bits; /* of all channels with their checksums, without START, CDS and STOP */
  bool cds0;             /* CDS must be 0 */
} biss_format_size;

/* BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_format_size_of(const biss_format* format, biss_format_size* size);

/* The format in the grammar of the command ("pos26,nE,nW,crc6;cds0"), also of a catalogue name,
 * with a final zero. *length, unless null, is the number of characters without it.
 * BISS_FORMAT_TEXT_MAX bytes are always enough.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_NO_ROOM: `room` is too small; *length is set. */
#define BISS_FORMAT_TEXT_MAX 1024
biss_status biss_format_text(const biss_format* format, char* text, size_t room, size_t* length);

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
  uint32_t lead_min_clocks; /* ones before ACK; 1 to 402 */
  uint32_t lead_max_clocks;
  uint32_t ack_min_clocks; /* zeros of ACK; 1 to 400 */
  uint32_t ack_max_clocks;
  uint32_t late_max_clocks; /* zeros in place of the first ones, for an encoder that is ready after
                               a fixed time; usually 0 */
} biss_bounds;

/* The widest that BiSS C allows at 10 MHz. */
biss_bounds biss_bounds_defaults(void);

/* Finds and decodes the frame in bits `first_bit` to `first_bit` + `bit_count` - 1 of `bytes`; bits
 * beyond the buffer do not exist, and bits after STOP are ignored. `bytes` may be null if
 * `byte_count` is 0. `bounds` may be null: biss_bounds_defaults(). Any cause. BISS_NULL_ARGUMENT,
 * BISS_BAD_HANDLE, BISS_BAD_FORMAT, BISS_BAD_SETUP: a bound is out of its range, or a minimum is
 * above its maximum. */
biss_status biss_frame_decode(const biss_format* format, const uint8_t* bytes, size_t byte_count,
                              size_t first_bit, size_t bit_count, const biss_bounds* bounds,
                              biss_frame* frame);

/* The bits that biss_frame_encode() writes at most, and the bytes they take. */
#define BISS_FRAME_BITS_MAX 1445
#define BISS_FRAME_BYTES_MAX 181

/* A frame to be encoded: the format's number of channels with position and counter 0 and neither
 * error nor warning, one leading one, one clock of ACK, CDS 0.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_frame_defaults(const biss_format* format, biss_frame* frame);

/* SLO once per clock of MA: `lead_clocks` ones, `ack_clocks` zeros, START, CDS, each channel with
 * its checksum, STOP. *bit_count is their number; the last byte is filled with zeros. `cause`,
 * `stop_seen`, `no_error_flag` and `unchecked` are ignored.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_BAD_FORMAT, BISS_CHANNEL_COUNT: not as in the format,
 * BISS_VALUE_RANGE: a position or counter is wider than its field, BISS_CLOCK_RANGE: `ack_clocks`
 * is not 1 to 400 or `lead_clocks` is above 402, BISS_NO_ROOM: `byte_count` is too small;
 * *bit_count is set and `bytes` unchanged. */
biss_status biss_frame_encode(const biss_format* format, const biss_frame* frame, uint8_t* bytes,
                              size_t byte_count, size_t* bit_count);

/* ---- SPI ---- */

typedef struct biss_spi biss_spi;

typedef struct biss_spi_setup {
  const biss_format* format;
  const biss_timing* timing; /* null: of the format's name, see biss_timing_of() */
  int64_t period_ps;         /* of MA, 32 ps or more */
  bool sample_on_falling;    /* CPHA = 0, mode 2; false: CPHA = 1, mode 3. CPOL is 1 */
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

/* Opens a reader of the buffers of one encoder. *spi is null unless BISS_OK.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_BAD_TIMING, BISS_BAD_SETUP, BISS_CLOCK_MAX,
 * BISS_NO_ERROR_FLAG, BISS_NO_CRC, BISS_NO_MEMORY. */
biss_status biss_spi_open(const biss_spi_setup* setup, biss_spi** spi);

/* Null is allowed. */
void biss_spi_close(biss_spi* spi);

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

/* ---- Checksums ---- */

/* The checksum that a BiSS master uses if only its width is given: start 0, inverted. For widths
 * other than 3 to 8 and 16 the polynomial is 0. */
biss_crc biss_crc_defaults(uint32_t width_bits);

/* The checksum of the lowest `bits` bits of `data`, 1 to 64, the most significant first, as
 * transmitted. BISS_NULL_ARGUMENT, BISS_BAD_CRC: no such checksum, or an error of a maker,
 * BISS_BIT_COUNT: `bits` is not 1 to 64, BISS_VALUE_RANGE: `data` has a 1 above them. */
biss_status biss_crc_of(const biss_crc* crc, uint64_t data, uint32_t bits, uint32_t* value);

#ifdef __cplusplus
}
#endif
