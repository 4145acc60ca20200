/* Simulation for C: the far end of a line (cable, encoder and their faults), and VCD files. Units,
 * levels, errors and lifetimes are defined in biss_c.h. This part is a library of its own,
 * biss_c_sim, because it needs the C++ library. */
#pragma once

#include <biss_c.h>

BISS_C_BEGIN

/* ---- Faults by name ---- */

/* The kinds of faults of `biss simulate --fault`, from 0 to biss_fault_count() - 1. */
size_t biss_fault_count(void);
/* "flip", "glitch_ma", …; null if there is no such kind. */
const char* biss_fault_name(size_t kind);
/* The effect of a fault, without a full stop; null if there is no such kind. */
const char* biss_fault_effect(size_t kind);

/* ---- The far end of a line ---- */

/* The only objects with memory of the heap, and with a file: end them with their close. */
BISS_OBJECT(biss_line, 1);

/* A stepper between the pins of a master and the encoder at the end of its cable: MA in, SLO out.
 * The master is a biss_master, or a master of the caller. */
typedef struct biss_line_setup {
  const biss_format* format;
  uint32_t clock_hz;   /* of the master, 1 kHz to 100 MHz: faults are placed by it */
  int64_t interval_ps; /* from one request to the next, likewise; 0: the shortest */
  /* One way in the cable, from MA to SLO in the encoder, and the filter of MA: pulses that are
   * shorter do not reach the encoder, every other edge is delayed by it. Together at most 40 us. */
  int64_t ma_delay_ps;
  int64_t slo_delay_ps;
  int64_t internal_delay_ps;
  int64_t ma_filter_ps;
  /* Peak edge jitter (+-), at most the delay of its direction, for SLO including the internal one.
   * An edge never comes before the previous one. */
  int64_t ma_jitter_ps;
  int64_t slo_jitter_ps;
  /* The time from ACK to the answer: each request has a random time from `ready_min_ps` to
   * `ready_max_ps`, limited to ack_max_ps. */
  int64_t ready_min_ps;
  int64_t ready_max_ps;
  /* "constant", "ramp", "sine", "random", "max", as `biss simulate --motion`; null: "ramp". */
  const char* motion;
  /* Instead of a motion: the position of the first word that has one, as of `moment_ps`; the other
   * words repeat it in their resolution. Called once per frame by biss_line_step(). */
  uint64_t (*position)(void* user, int64_t moment_ps);
  void* user;
  uint32_t counter_first; /* 0 or 1: the lowest sign of life */
  uint32_t counter_start; /* of the first frame, from counter_first to 63 */
  /* The encoder has registers, see biss_line_put_register(); not with a format with cds0. */
  bool registers;
  uint32_t register_busy_frames; /* by which each byte is delayed, up to 65535 */
  uint64_t seed;
  /* Rules as in `biss simulate --fault`, separated by white space: "flip:0.01 cut@40,clock=12.25".
   * Null: none. */
  const char* faults;
  /* The caller has the encoder, and the line is only the cable with its faults. A fall of MA more
   * than 1.25 periods after the one before begins a request. `position` and `registers` must be
   * null and false; the other members for the encoder have no effect, nor has
   * biss_line_set_flags(). */
  bool foreign_encoder;
} biss_line_setup;

/* A setup without delays and faults, a ramp, counters from 1, seed 1. */
biss_line_setup biss_line_defaults(const biss_format* format, uint32_t clock_hz);

/* Makes a line whose encoder is idle.
 * BISS_NULL_ARGUMENT, BISS_NO_MEMORY, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_BAD_SETUP,
 * BISS_FAULT_RULE: a rule is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE, BISS_FAULT_KIND:
 * no such kind, or a kind of the encoder, which belongs to the caller, BISS_FAULT_PLACE: a frame of
 * this line has no such place, or the kind has none, BISS_FAULT_TWICE: a kind has two rates, or one
 * cycle twice. */
biss_status biss_line_init(biss_line* line, const biss_line_setup* setup);

/* The index in setup->faults of the wrong rule; 0 if no rule is wrong. */
size_t biss_line_fault_at(const biss_line_setup* setup);

typedef struct biss_line_output {
  bool slo;            /* at the master */
  bool ma;             /* at the encoder */
  int64_t deadline_ps; /* call step again at this time if no input changes before; or BISS_NEVER */
} biss_line_output;

/* To be called at each change of MA, or of SLO of the caller's encoder, and at the deadline;
 * further calls change nothing. Events due before `now_ps` happen first. `encoder_slo` is ignored
 * if the encoder does not belong to the caller. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE,
 * BISS_TIME_RANGE, BISS_TIME_BACKWARDS, BISS_REENTERED, BISS_VALUE_RANGE: as biss_slave_step(),
 * BISS_NO_MEMORY: the line no longer works, and every further step returns this. */
biss_status biss_line_step(biss_line* line, int64_t now_ps, bool ma, bool encoder_slo,
                           biss_line_output* out);

/* nE and nW that the encoder reports besides its faults, from the next frame on.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_REENTERED. */
biss_status biss_line_set_flags(biss_line* line, bool nE, bool nW);

#define BISS_LINE_PLACES 16

/* The place in a request at which a fault begins. */
typedef struct biss_fault_place {
  uint32_t kind; /* as for biss_fault_name() */
  bool is_bit;   /* a bit of data and checksums; false: a period of MA, from its first fall */
  uint64_t thousandths; /* of a bit or a clock */
} biss_fault_place;

/* The last request that began, as far as it has come. A request begins when MA falls after an idle
 * time as long as the encoder's timeout, or while the encoder is idle after an answer. A shorter
 * idle time is part of the request: a gap between the bytes of an SPI master. */
typedef struct biss_line_request {
  uint64_t number;  /* counts from 0 */
  int64_t begin_ps; /* MA fell at the master */
  /* The encoder took a position; if not, all members from here on are 0 or 1. If it took several
   * after a fault: the first one that it sent completely, else the first one that it began to send,
   * else the first one. */
  bool sampled;
  int64_t sampled_ps;
  uint32_t channel_count;
  biss_channel channels[BISS_MAX_CHANNELS]; /* what it sends if no fault changes it */
  uint64_t faults;                          /* in this request: bit k for kind k */
  uint32_t place_count; /* of faults with a place; `places` has the first ones */
  biss_fault_place places[BISS_LINE_PLACES];
  int64_t late_ps; /* the fault `delay`: how much later than usual the next request is to come */
} biss_line_request;

/* BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_REENTERED, BISS_NO_READING: no request yet. */
biss_status biss_line_request_of(const biss_line* line, biss_line_request* request);

/* Makes a register of the encoder available: 0x00 to 0x3F of a bank 0 to 255; 0x40, which selects
 * the bank (the bank it starts with is `value`); 0x41 to 0x7F, with `bank` ignored. The encoder
 * has this value again when it has lost its supply. At first no register is available.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_REENTERED, BISS_NO_REGISTER: in the setup there
 * are none, or no such address or bank. */
biss_status biss_line_put_register(biss_line* line, uint32_t bank, uint32_t address, uint8_t value,
                                   bool writable);

/* The register as it is now, even if the master may not read it. Errors as above. */
biss_status biss_line_register(biss_line* line, uint32_t bank, uint32_t address, uint8_t* value);

/* The encoder's state as biss_slave_state(); null without init, or if the encoder
 * belongs to the caller. */
const char* biss_line_state(const biss_line* line);

/* Null is allowed. Not from its own callback. */
void biss_line_close(biss_line* line);

/* ---- VCD ---- */

#define BISS_VCD_SIGNALS 64

BISS_OBJECT(biss_vcd, 12);

/* Creates a VCD file with a time scale of 1 ps and one wire for each name; white space and control
 * characters in names become `_`. Every signal is 1 at time 0, as MA and SLO are idle; `level` at
 * the same time changes that.
 * BISS_NULL_ARGUMENT, BISS_BAD_SETUP: not 1 to 64 names, or an empty one, BISS_FILE: the file
 * cannot be written; errno has the reason. */
biss_status biss_vcd_init(biss_vcd* vcd, const char* path, const char* const* names, size_t count);

/* The level of a signal from `time_ps` on, 0 or later. A level that it has already is not written.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_BAD_SETUP: no such signal, BISS_TIME_RANGE,
 * BISS_TIME_BACKWARDS, BISS_FILE. */
biss_status biss_vcd_put(biss_vcd* vcd, int64_t time_ps, size_t signal, bool level);

/* Ends the file at `time_ps`, at the last change if that is later, and closes it in any
 * case. Null is allowed. BISS_BAD_HANDLE, BISS_TIME_RANGE: the file ends at the last change,
 * BISS_FILE: it is not complete. */
biss_status biss_vcd_close(biss_vcd* vcd, int64_t time_ps);

BISS_C_END
