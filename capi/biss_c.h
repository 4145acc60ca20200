/* Both sides of a BiSS C line, encoder and master, for C and for all that calls C: simulators,
 * Verilator and VPI/DPI, bindings of other languages. biss_c_frame.h has frames, SPI buffers and
 * checksums; biss_c_control.h registers, commands and data sheets; biss_c_safety.h the monitor for
 * BiSS Safety; biss_c_sim.h faults, cables and VCD files. Encoder and master are steppers: nothing
 * runs by itself, time and levels are arguments. The caller models cable and noise: a level that
 * one side drives reaches the other side when the caller passes it on.
 *
 *   Times     int64_t in picoseconds, -BISS_TIME_MAX to BISS_TIME_MAX, with any zero. The time of
 *             an object never goes backwards. Durations are 0 to BISS_DURATION_MAX.
 *   Levels    bool: false low, true high. MA and SLO idle high.
 *   Errors    each call returns a biss_status. A call that does not return BISS_OK has changed
 *             nothing unless its description says otherwise. No C++ exception leaves a call.
 *   Memory    an object (biss_slave, biss_master, ...) is the caller's: static, on the stack, or in
 *             a structure. No call allocates memory. Its content is private. An object works from
 *             its init on, and only at the address of its init; a later init starts again. Every
 *             call checks that: memory without init, memory after an init that failed, a copy, and
 *             an object of another kind are BISS_BAD_HANDLE. Nothing has to be freed: set an
 *             object to zero to end it. The arguments of init may be freed when init returns,
 *             except for `user`, which is passed to the callbacks. Returned texts are static.
 *   Threads   an object belongs to one thread at a time. Different objects share nothing. A
 *             callback may call everything except the object that called it, and must return: no
 *             longjmp, no exception. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The declarations of a header are between the first two. BISS_INT: in C++ an enumeration that may
 * hold any int, so that a number out of its range is valid. */
#ifdef __cplusplus
#define BISS_C_BEGIN extern "C" {
#define BISS_C_END }
#define BISS_INT : int
#else
#define BISS_C_BEGIN
#define BISS_C_END
#define BISS_INT
#endif

BISS_C_BEGIN

/* The version of this header: as a text, and as 10000 for each major, 100 for each minor version
 * and 1 for each patch. */
#define BISS_C_VERSION "0.1.0"
#define BISS_C_VERSION_NUMBER 100

#define BISS_TIME_MAX (INT64_MAX / 4)
#define BISS_DURATION_MAX INT64_C(1000000000000) /* one second */
/* A deadline that never comes: only an input matters. */
#define BISS_NEVER INT64_MAX
#define BISS_MAX_CHANNELS 8

/* An object: a structure of the caller with private content. */
#define BISS_OBJECT(name, words) \
  typedef struct name {          \
    uintptr_t mark;              \
    uint64_t memory[words];      \
  } name
/* The memory of the largest part of an object: a frame format with its tables. BISS_SMALL selects
 * small tables on other processors than Arm's Cortex-M; then define it for the library too. */
#if defined(BISS_SMALL) || (defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M')
#define BISS_CODEC_WORDS 176
#else
#define BISS_CODEC_WORDS 4208
#endif
/* A program with small objects does not link with a library that fills large ones. */
#ifdef BISS_SMALL
#define biss_codec_init biss_codec_init_small
#define biss_spi_init biss_spi_init_small
#define biss_slave_init biss_slave_init_small
#define biss_master_init biss_master_init_small
#define biss_safety_init biss_safety_init_small
#endif

/* The version of the library, as BISS_C_VERSION. */
const char* biss_version(void);

/* The result of a call. */
typedef enum biss_status BISS_INT {
  BISS_OK = 0,
  BISS_NULL_ARGUMENT,  /* a required pointer is null */
  BISS_NO_MEMORY,      /* biss_line: no memory */
  BISS_BAD_FORMAT,     /* a text is neither a catalogue name nor a format; see
                          biss_format_problem(). A biss_format has no channel, or fields that
                          overlap or are not in the data. For a master, a biss_spi and a single
                          frame: also a checksum of_previous, which needs the frame before */
  BISS_BAD_TIMING,     /* a biss_timing that no device can have: a duration out of range, an
                          unknown rule or clock count, a minimum above its maximum */
  BISS_BAD_SETUP,      /* another value of the setup is out of its range */
  BISS_TIME_RANGE,     /* a time beyond BISS_TIME_MAX */
  BISS_TIME_BACKWARDS, /* a time before the last one of this object */
  BISS_REENTERED,      /* called from its own callback */
  BISS_VALUE_RANGE,    /* a position or counter is wider than its field. For `sample` of a slave:
                          the step was done and its output is valid; the frame means "no data": all
                          positions and counters 0, nE and nW active */
  BISS_RUNNING,        /* begin, reading: a request is running */
  BISS_SLO_LOW,        /* begin: refused, the encoder is not ready */
  BISS_TOO_EARLY,      /* begin: refused, the device's shortest cycle has not passed, or MA was not
                          high long enough */
  BISS_NO_READING,     /* reading: no request was made yet, or there is no frame */
  BISS_BAD_HANDLE,     /* the object had no init, was moved, or is of another kind */
  BISS_CHANNEL_COUNT,  /* the format has a different number of channels, or no such channel */
  BISS_CLOCK_RANGE,    /* clocks of ACK or before it: more or fewer than possible */
  BISS_NO_ROOM,        /* the buffer is too small */
  BISS_BAD_CRC,        /* a biss_crc is not a checksum: its width is not 3 to 16, its polynomial
                          not in full form, or its start wider */
  BISS_BIT_COUNT,      /* a number of bits is not 1 to 64 */
  BISS_FAULT_RULE,     /* a fault is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE */
  BISS_FAULT_KIND,     /* no such kind of fault, or one of the encoder, which is the caller's */
  BISS_FAULT_PLACE,    /* a frame of this line has no such place, or the kind has none */
  BISS_FAULT_TWICE,    /* a kind of fault is given twice with a rate or for one cycle */
  BISS_NO_REGISTER,    /* no such register, or the encoder has none */
  BISS_FILE,           /* the file cannot be written; errno has the reason */
  BISS_BAD_EDS,        /* the data sheet has no data channel, the length of one is not known, or it
                          contradicts itself or the registers */
  BISS_BAD_SAFETY,     /* these frames cannot be monitored; see biss_safety_problem() */
  BISS_CLOCK_MAX,      /* the clock is above clock_max of the encoder */
  BISS_NO_ERROR_FLAG,  /* a position has no nE, and the setup does not have no_error_flag */
  BISS_NO_CRC          /* a channel has no checksum, and the setup does not have unchecked */
} biss_status;

/* The enumerator's name in lower case without "biss_": "slo_low"; "unknown" for any other number.
 */
const char* biss_status_name(biss_status status);
/* A message for a user, without a full stop; "no such status" for any other number. */
const char* biss_status_text(biss_status status);

/* ---- Format and timing of a device ---- */

typedef enum biss_timeout_rule BISS_INT {
  BISS_TIMEOUT_ADAPTIVE = 0, /* 1.5 periods of MA and up to `time_ps` after its last edge */
  BISS_TIMEOUT_FIXED,        /* `time_ps` after the last edge of MA */
  BISS_TIMEOUT_CYCLE         /* `time_ps` after the start of the request (Renishaw) */
} biss_timeout_rule;

typedef struct biss_timeout {
  uint8_t rule; /* a biss_timeout_rule */
  int64_t time_ps;
  uint8_t release_half_periods; /* BISS_TIMEOUT_CYCLE: how long SLO is low after the last edge of MA
                                   of a longer frame, 2 to 255; 0: the default, 3 */
  int64_t shortest_ps;          /* the shortest fixed timeout; 0: not stated */
} biss_timeout;

/* The timing of a type of encoder. */
typedef struct biss_timing {
  uint32_t clock_min_hz; /* not checked here */
  uint32_t clock_max_hz;
  int64_t start_min_ps; /* first rising edge of MA (LAT) to START, at least */
  int64_t ack_max_ps;   /* second rising edge (ACK) to the answer, at most */
  uint16_t ack_clocks;  /* clocks of ACK if their number is fixed, up to 400; 0: not fixed */
  biss_timeout timeout;
  int64_t internal_delay_max_ps; /* not checked here */
  int64_t cycle_min_ps;          /* from one request to the next, at least */
  int64_t sampling_min_ps;       /* LAT to the moment whose position is sent */
  int64_t sampling_typical_ps;
  int64_t sampling_max_ps;
  bool clock_constant; /* the clock must not change within a request, nor pause; not checked here */
  bool duty_even;      /* MA must be high for half of each period; not checked here */
} biss_timing;

/* A checksum, as data. */
typedef struct biss_crc {
  uint32_t polynomial; /* in full form, with the top and the lowest term: 0x43 = x^6 + x + 1 */
  uint16_t start;      /* of the register, at most 2^width_bits - 1 */
  uint8_t width_bits;  /* 3 to 16; 0 in a biss_channel_format: no checksum */
  bool inverted : 1;   /* sent with every bit inverted, as BiSS does */
  /* Errors of an encoder's maker, which formats have as suffixes: bits reversed, without nE and nW,
   * CDS covered too, of the frame before. All false for biss_crc_of(). */
  bool reversed : 1;
  bool without_flags : 1;
  bool with_cds : 1;
  bool of_previous : 1;
} biss_crc;

/* A run of bits in the data of a channel. */
typedef struct biss_field {
  uint8_t shift; /* the number of data bits after it */
  uint8_t bits;  /* 0: the channel has no such field */
} biss_field;

typedef struct biss_flag {
  uint8_t shift; /* the number of data bits after it */
  bool present;
  bool active_high; /* E or W; false: nE or nW */
} biss_flag;

/* One data channel. Bits of no field are padding. The position is one field, or the turns and the
 * position in the turn. Each of them is a binary number with its highest bit first, or in Gray
 * code, or with its lowest bit first. */
typedef struct biss_channel_format {
  uint8_t data_bits; /* 1 to 64, without the checksum */
  biss_field position;
  biss_field multiturn;
  biss_field singleturn;
  bool position_gray : 1;
  bool multiturn_gray : 1;
  bool singleturn_gray : 1;
  bool position_lsb : 1;
  bool multiturn_lsb : 1;
  bool singleturn_lsb : 1;
  biss_flag error;
  biss_flag warning;
  biss_field life_counter; /* up to 32 bits */
  biss_crc crc;
} biss_channel_format;

/* A frame format and the timing of its device, as plain data: it may be a constant. Every init
 * that takes one copies it. */
typedef struct biss_format {
  biss_timing timing;
  uint32_t channel_count;                          /* 1 to BISS_MAX_CHANNELS */
  bool cds0;                                       /* CDS must be 0 */
  biss_channel_format channels[BISS_MAX_CHANNELS]; /* in the order on the line */
} biss_format;

/* A format without channels, with the widest timing that BiSS C allows. */
biss_format biss_format_defaults(void);

/* ---- Formats as texts: the only calls that need the catalogue and the grammar ---- */

/* The encoders of the catalogue, from 0 to biss_encoder_count() - 1. */
size_t biss_encoder_count(void);
/* "resolute-26", …: a text for biss_format_parse(); null if there is no such encoder. */
const char* biss_encoder_name(size_t index);

/* The format of a catalogue name ("resolute-26"), or of the grammar of the command
 * ("pos26,nE,nW,crc6;cds0", "mt12,st20,nE,nW,lc6,crc16") with the widest timing.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT. */
biss_status biss_format_parse(const char* text, biss_format* format);

/* Returns null when the text is a format, otherwise the mistake, and in *at (unless null) the index
 * of its character. A null text is an empty one. */
const char* biss_format_problem(const char* text, size_t* at);

/* The format in the grammar of the command, with a final zero. *length, unless null, is the number
 * of characters without it. BISS_FORMAT_TEXT_MAX bytes are always enough.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_NO_ROOM: `room` is too small; *length
 * is set. */
#define BISS_FORMAT_TEXT_MAX 1024
biss_status biss_format_text(const biss_format* format, char* text, size_t room, size_t* length);

/* ---- Values ---- */

/* The values of one data channel. */
typedef struct biss_channel {
  uint64_t position;     /* unsigned, multiturn above singleturn; 0: none */
  uint32_t life_counter; /* 0: none */
  bool nE;               /* low-active: false = error, do not use the position */
  bool nW;               /* low-active: false = warning */
} biss_channel;

/* The result of a stepper. Both values hold until its next call. */
typedef struct biss_output {
  bool level;          /* what it drives from now on: the slave SLO, the master MA */
  int64_t deadline_ps; /* call step again at this time if no input changes before; or BISS_NEVER */
} biss_output;

/* ---- The encoder's side ---- */

BISS_OBJECT(biss_slave, BISS_CODEC_WORDS + 110);

typedef struct biss_slave_setup {
  const biss_format* format;
  int64_t ready_ps; /* from ACK to the answer, limited to ack_max_ps */
  bool chained;     /* SLI comes from another slave; false: SLI is ignored */
  void* user;       /* passed to the callbacks; may be null */
  /* Called once per frame, at the sampling moment, by biss_slave_step(): sets channels[0] to
   * channels[count - 1], in the order on the line. They are initialised with position and counter 0
   * and neither error nor warning. `moment_ps` may be before the time of the step. Not null. */
  void (*sample)(void* user, int64_t moment_ps, biss_channel* channels, size_t count);
  /* The encoder's own CDS bit, called when it is sent. A chained encoder sends its bit or its
   * predecessor's 1. Null: 0. */
  bool (*cds)(void* user);
  /* Called with the CDM bit when a frame has ended. May be null. */
  void (*cdm)(void* user, bool bit);
  /* Registers, 0 to 127. If these three are set, the encoder takes an ID and answers the control
   * communication itself; `cds` and `cdm` must be null, and the format without cds0. It obeys the
   * commands that switch its channels and its control communication.
   *   register_permits  false: the access is refused
   *   register_read     the value, or -1: busy, called again with the next frame
   *   register_write    takes a byte whose CRC was right */
  bool (*register_permits)(void* user, bool write, uint8_t address);
  int (*register_read)(void* user, uint8_t address);
  void (*register_write)(void* user, uint8_t address, uint8_t value);
} biss_slave_setup;

/* A setup with this format, and 0 or null everywhere else. */
biss_slave_setup biss_slave_defaults(const biss_format* format);

/* Makes an idle encoder that drives SLO high.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_BAD_SETUP. */
biss_status biss_slave_init(biss_slave* slave, const biss_slave_setup* setup);

/* To be called at each change of MA or SLI and at the deadline; further calls change nothing.
 * Events due before `now_ps` happen first.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_TIME_RANGE, BISS_TIME_BACKWARDS, BISS_REENTERED,
 * BISS_VALUE_RANGE. */
biss_status biss_slave_step(biss_slave* slave, int64_t now_ps, bool ma, bool sli, biss_output* out);

/* The state, by what it waits for: "idle", "requested", "latched", "ack", "start", "data", "stop",
 * "early_request" (a request came before the timeout was over and is not answered), "chain_busy".
 * Null without init. */
const char* biss_slave_state(const biss_slave* slave);

/* ---- The master's side ---- */

BISS_OBJECT(biss_master, BISS_CODEC_WORDS + 98);

typedef struct biss_control biss_control;

/* A time of 0 selects the default in the comment. */
typedef struct biss_master_setup {
  const biss_format* format;
  int64_t period_ps;         /* of MA; 32 ps or more */
  bool compensate;           /* sample half a period after each bit's arrival, by the line delay
                                measured in this request; false: half a period after the edge */
  uint32_t slaves;           /* devices in a daisy chain, 1 to 8 */
  uint32_t extra_clocks;     /* clocks after the one of STOP, up to 65535 */
  int64_t low_time_ps;       /* MA low in each clock, below the period; half a period */
  int64_t sample_step_ps;    /* resolution of the sampling point; a sixteenth of the period */
  int64_t sample_shift_ps;   /* from the middle, at most half a period in both directions */
  int64_t line_delay_max_ps; /* the longest wait for ACK; 40 us */
  int64_t reset_time_ps;     /* MA high after a failed request, from its last edge; the rest of the
                                full request cycle, as the device needs it */
  int64_t idle_min_ps;       /* MA high between requests; half a period */
  biss_control* control; /* registers and commands, biss_c_control.h: it gives CDM from each CDS,
                                and belongs to this master alone; null: none */
  bool trust_cycle_time; /* BISS_TIMEOUT_CYCLE: done when its time has passed; begin is then
                                possible while SLO is low, which rises a line delay later */
  bool no_error_flag;    /* reads positions without nE too: such an encoder cannot report that its
                         position is wrong, and a word of zeros is position 0 */
  bool unchecked;        /* reads channels without checksum too: a disturbed one is then good */
} biss_master_setup;

/* A setup with compensation for one device, defaults everywhere else. */
biss_master_setup biss_master_defaults(const biss_format* format, int64_t period_ps);

/* The one cause why there is no frame; the same as the statuses of `biss decode`. */
typedef enum biss_cause BISS_INT {
  BISS_CAUSE_OK = 0,
  BISS_CAUSE_NO_RESPONSE,    /* SLO stayed high */
  BISS_CAUSE_NOT_READY,      /* refused; MA did not move */
  BISS_CAUSE_RESPONSE_RANGE, /* SLO was low before ACK could begin, or ACK came too late */
  BISS_CAUSE_NO_START,       /* ACK exceeded the device's bound */
  BISS_CAUSE_ACK_RANGE,      /* START came before the device can answer */
  BISS_CAUSE_TRUNCATED,      /* not from a master: the clock stopped early */
  BISS_CAUSE_CDS,            /* CDS was 1 and the format has cds0 */
  BISS_CAUSE_CRC,            /* the checksum of `cause_channel` is wrong */
  BISS_CAUSE_STOP_BIT        /* the bit after the last CRC bit was 1 */
} biss_cause;

/* The name in the output of `biss decode`: "ok", "no_response", …; "unknown" for any other
 * number. */
const char* biss_cause_name(biss_cause cause);

/* The result of a request. */
typedef struct biss_reading {
  biss_cause cause;
  uint32_t cause_channel; /* counts from 0 */
  /* Channels of the frame, in the order on the line; 0 unless `cause` is BISS_CAUSE_OK. */
  uint32_t channel_count;
  biss_channel channels[BISS_MAX_CHANNELS];
  bool cds;
  int64_t begin_ps;         /* first falling edge of MA, or the time of the refusal */
  bool line_delay_measured; /* ACK began */
  int64_t line_delay_ps;    /* second rising edge of MA to the fall of SLO */
  uint32_t ack_clocks;      /* zeros of ACK as sampled */
  uint32_t clocks;          /* rising edges of MA */
  bool marginal;            /* SLO changed within a twentieth of a period of a sampling instant */
  bool ready;               /* SLO is high at the end, or known to rise (trust_cycle_time) */
} biss_reading;

/* Makes a master that drives MA high.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_BAD_SETUP, BISS_CLOCK_MAX,
 * BISS_NO_ERROR_FLAG, BISS_NO_CRC, BISS_BAD_HANDLE: `control`. */
biss_status biss_master_init(biss_master* master, const biss_master_setup* setup);

/* Begins a request: MA falls at `now_ps`. `cdm` is the bit it carries; ignored if the setup has a
 * control session.
 * BISS_SLO_LOW and BISS_TOO_EARLY: no request is made, the reading has the cause not_ready, and
 * out->deadline_ps is when to try again, BISS_NEVER: when SLO rises.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_TIME_RANGE, BISS_TIME_BACKWARDS, BISS_RUNNING. */
biss_status biss_master_begin(biss_master* master, int64_t now_ps, bool slo, bool cdm,
                              biss_output* out);

/* To be called at each change of SLO and at the deadline, until biss_master_done(); further calls
 * change nothing. A change and a sample at the same time may be reported in either order.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_TIME_RANGE, BISS_TIME_BACKWARDS. */
biss_status biss_master_step(biss_master* master, int64_t now_ps, bool slo, biss_output* out);

/* No request is running. Every request ends by itself, whatever SLO does. True without
 * init. */
bool biss_master_done(const biss_master* master);

/* The outcome of the last request.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_RUNNING, BISS_NO_READING. */
biss_status biss_master_reading(const biss_master* master, biss_reading* reading);

BISS_C_END
