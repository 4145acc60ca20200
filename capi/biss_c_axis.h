/* An axis: a position for a drive in every cycle, from an SPI with DMA. docs/axis.md explains
 * states, causes and limits. Units, levels, errors and memory are defined in biss_c.h, biss_spi in
 * biss_c_frame.h.
 *
 *   control timer interrupt                   DMA complete interrupt
 *   ---------------------------------------   ------------------------------
 *   biss_axis_get(): use it                   biss_axis_complete()
 *   biss_axis_request(): the SPI starts  -->    decode, turns, limits, rules
 *
 * Give both interrupts the same priority. Here `now_ps` may be any time of a clock that wraps
 * around at the limits of its type. */
#pragma once

#include <biss_c_frame.h>

BISS_C_BEGIN

/* The result of a cycle. Up to BISS_AXIS_STOP_BIT, biss_cause has the same numbers. */
typedef enum biss_axis_cause BISS_INT {
  BISS_AXIS_OK = 0, /* the position was measured */
  BISS_AXIS_NO_RESPONSE,
  BISS_AXIS_NOT_READY,
  BISS_AXIS_RESPONSE_RANGE,
  BISS_AXIS_NO_START,
  BISS_AXIS_ACK_RANGE,
  BISS_AXIS_TRUNCATED,
  BISS_AXIS_CDS,
  BISS_AXIS_CRC,
  BISS_AXIS_STOP_BIT,
  BISS_AXIS_ERROR_BIT,  /* nE is 0 */
  BISS_AXIS_TURNS,      /* half a turn was possible since the last measured position */
  BISS_AXIS_STEP,       /* farther than max_step allows */
  BISS_AXIS_WARNING,    /* nW is 0; measured, unless the setup has another rule */
  BISS_AXIS_EARLY,      /* measured, but within an eighth of a cycle after the position before */
  BISS_AXIS_FIRST,      /* the first good frame, which the next one has to confirm */
  BISS_AXIS_LATE,       /* no request: the transfer before has not ended */
  BISS_AXIS_UNANSWERED, /* the end of the transfer was never reported */
  BISS_AXIS_FAILED,     /* the transfer ended with an error */
  BISS_AXIS_TRIPPED,    /* a good frame after a trip, or biss_axis_trip() */
  BISS_AXIS_UNEXPECTED  /* not a cycle: an end that no request waits for */
} biss_axis_cause;

/* The name in docs/axis.md: "ok", "no_response", …; "unknown" for any other number. */
const char* biss_axis_cause_name(biss_axis_cause cause);

typedef enum biss_axis_state BISS_INT {
  BISS_AXIS_NO_POSITION = 0,
  BISS_AXIS_MEASURED,
  BISS_AXIS_HELD,         /* the last measured position */
  BISS_AXIS_EXTRAPOLATED, /* moved on at the last measured speed */
  BISS_AXIS_STOPPED       /* tripped: stop the drive */
} biss_axis_state;

typedef enum biss_bad_cycle_rule BISS_INT {
  BISS_BAD_HOLD = 0,
  BISS_BAD_EXTRAPOLATE,
  BISS_BAD_TRIP
} biss_bad_cycle_rule;

typedef enum biss_warning_rule BISS_INT {
  BISS_WARNING_MEASURE = 0, /* the position counts */
  BISS_WARNING_BAD,         /* a bad cycle */
  BISS_WARNING_TRIP
} biss_warning_rule;

/* For biss_axis_setup.max_step: any step below half of the encoder's range. */
#define BISS_NO_STEP_LIMIT INT64_MAX
/* The bytes that a transfer may have. */
#define BISS_AXIS_BYTES 128

typedef struct biss_axis_setup {
  const biss_spi* spi; /* of a format with one channel; must outlive the axis */
  /* Starts a transfer into `bytes`, which must be in memory before the DMA writes. False: the
   * transfer before has not ended, and nothing was started. Not null. */
  bool (*start)(void* user, uint8_t* bytes, size_t count);
  void* user;       /* passed to `start` */
  int64_t cycle_ps; /* from one request to the next, up to 100 s; one may come an eighth later */
  int64_t max_step; /* the largest movement in one cycle and that eighth, in counts; below half of
                       the encoder's range */
  biss_bad_cycle_rule bad_cycles; /* default: BISS_BAD_EXTRAPOLATE */
  biss_warning_rule warnings;     /* default: BISS_WARNING_MEASURE */
  uint32_t trip_after;            /* bad cycles in a row, up to 65535; default: 4 */
  int64_t power_up_ps;            /* default: one second */
  bool reversed;                  /* counts down when the encoder counts up */
  int64_t offset;                 /* the position at the encoder's count 0, below 2^62 */
} biss_axis_setup;

/* A setup with the defaults above. */
biss_axis_setup biss_axis_defaults(const biss_spi* spi, int64_t cycle_ps, int64_t max_step);

BISS_OBJECT(biss_axis, 70);

/* BISS_NULL_ARGUMENT, BISS_BAD_HANDLE: `spi`, BISS_BAD_FORMAT: not one position of 1 to 62 bits,
 * BISS_NO_ROOM: the transfer is longer than BISS_AXIS_BYTES, BISS_BAD_SETUP. */
biss_status biss_axis_init(biss_axis* axis, const biss_axis_setup* setup);

/* Requests a position; call it once per cycle. `now_ps` is the time of the first falling edge of
 * MA. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, as all calls below. */
biss_status biss_axis_request(biss_axis* axis, int64_t now_ps);
/* The transfer has ended, well or with an error of the DMA. */
biss_status biss_axis_complete(biss_axis* axis);
biss_status biss_axis_failed(biss_axis* axis);

typedef struct biss_axis_position {
  int64_t position;    /* counts, with turns, direction and offset */
  int64_t uncertainty; /* at moment_ps the axis is within position ± this; INT64_MAX: not known */
  int64_t step;        /* counts per cycle */
  int64_t moment_ps;   /* the time to which the position belongs */
  uint32_t number;     /* the request whose frame was measured, from 1; 0: none yet */
  uint32_t bad_in_a_row;
  biss_axis_state state;
  biss_axis_cause cause; /* of the last cycle; after a trip, of the cycle that tripped */
  bool usable;           /* neither BISS_AXIS_NO_POSITION nor BISS_AXIS_STOPPED */
} biss_axis_position;

biss_status biss_axis_get(const biss_axis* axis, biss_axis_position* position);

/* How many cycles had this cause; 0 without init. */
uint32_t biss_axis_count(const biss_axis* axis, biss_axis_cause cause);

/* Starts again as after init, also after a trip; counts continue. Only after the drive has stopped
 * and the cause was found: turns count from 0. */
biss_status biss_axis_reset(biss_axis* axis);
biss_status biss_axis_trip(biss_axis* axis);
/* Sets the turns at the last measured position. BISS_NO_READING: there is none.
 * BISS_VALUE_RANGE. */
biss_status biss_axis_set_turns(biss_axis* axis, int64_t turns);

BISS_C_END
