/* The monitor of a BiSS Safety encoder; docs/safety.md explains its checks. Units, levels, errors
 * and lifetimes are defined in biss_c.h. The times of a monitor may have any value and wrap
 * around. */
#pragma once

#include <biss_c_frame.h>

BISS_C_BEGIN

BISS_OBJECT(biss_safety, BISS_CODEC_WORDS + 34);

typedef enum biss_counter_mode BISS_INT {
  BISS_COUNT_1_63 = 0,
  BISS_COUNT_0_63,
  BISS_COUNT_LEARNED /* either; start-up lasts until the counter has shown which one */
} biss_counter_mode;

/* A value above the largest of a sign of life: any. */
#define BISS_ANY_COUNTER 255

/* As SafetySetup of the core; the table of docs/safety.md has the same names. */
typedef struct biss_safety_setup {
  const biss_format* format; /* with two words; its timing is not used */
  uint32_t cpw;              /* channel of the control position word, from 0 */
  uint32_t spw;
  uint32_t start_frames; /* good frames in a row until one is safe, 2 to 255 */
  bool latch;            /* a fault holds until biss_safety_acknowledge() */
  uint32_t compare_bits; /* upper singleturn bits that are compared; 0: all common bits */
  uint32_t tolerance_lsb;
  bool ignore_turns;
  biss_counter_mode counter;
  bool perhaps_missed; /* the encoder may count a request without a good frame, or not */
  uint32_t near_frames;
  uint32_t learn_rollovers;
  uint32_t counter_first; /* of the first answer after power-up, or BISS_ANY_COUNTER */
  int64_t cycle_min_ps;   /* from request to request, at least; above 0, at most 100 s */
  /* The watchdog: from one good frame to the next; at most 100 s, and shorter than the counter's
   * period (63 or 64) times frame_gap_min_ps. */
  int64_t frame_gap_max_ps;
  int64_t frame_gap_min_ps;   /* 0: not checked, only with `unrated` */
  int64_t clock_tolerance_ps; /* from 0 to below frame_gap_max_ps */
  uint32_t still_requests;
  int64_t bit_period_ps; /* of the SPI clock; 0: the time of a transfer is not checked */
  uint32_t budget_faults;
  int64_t budget_window_ps;
  biss_bounds bounds;
  uint64_t residual_max_e15; /* undetected errors an hour, times 1e15; 1 % of SIL 2: 10000000 */
  /* For words that are in no table: the three numbers of `biss safety analyse --to c`. */
  uint64_t rating_words;
  uint64_t rating_residual_e24;
  uint64_t rating_check;
  bool unrated; /* without the checks of checksums, comparison and residual errors */
} biss_safety_setup;

/* The usual setup for requests every `cycle_ps`, as at_cycle() of the core: up to 100 s each is
 * valid; 0: the shortest.
 * BISS_NULL_ARGUMENT, BISS_BAD_SETUP: no such duration. */
biss_status biss_safety_defaults(const biss_format* format, int64_t cycle_ps,
                                 biss_safety_setup* setup);

/* The format and the setup of a safety configuration ("fs-36-28"), at this cycle; of another text,
 * its format with the usual setup. The setup has a pointer to *format.
 * Errors as above, and BISS_BAD_FORMAT. */
biss_status biss_safety_parse(const char* text, int64_t cycle_ps, biss_format* format,
                              biss_safety_setup* setup);

/* Why frames cannot be monitored with a setup: "no_counter", "frame_gap", …, the names of
 * SafetySetupError in biss/safety/setup.hpp. Null: they can, or the setup is bad in a different
 * way. */
const char* biss_safety_problem(const biss_safety_setup* setup);

/* Makes a monitor. It judges no frame before its self test.
 * BISS_NULL_ARGUMENT, BISS_BAD_FORMAT, BISS_BAD_TIMING, BISS_BAD_SETUP: a number is wider than its
 * field, BISS_BAD_SAFETY. */
biss_status biss_safety_init(biss_safety* safety, const biss_safety_setup* setup);

/* Gives every check a frame that it must refuse. Call it at power-up, and later at any time: a
 * later call that passes changes nothing. *passed is false in "failed", whatever the checks do.
 * `expected` is a setup from another place than the setup of init, a constant for example: the
 * monitor compares itself with it, all fields, now and before every frame. BISS_NULL_ARGUMENT,
 * BISS_BAD_HANDLE, and as biss_safety_init() for `expected`: BISS_BAD_FORMAT, BISS_BAD_SETUP,
 * BISS_BAD_SAFETY. Then the test has not passed and the monitor is unchanged. */
biss_status biss_safety_self_test(biss_safety* safety, const biss_safety_setup* expected,
                                  bool* passed);

typedef enum biss_verdict BISS_INT {
  BISS_VERDICT_SAFE = 0,
  BISS_VERDICT_STARTING,
  BISS_VERDICT_LATCHED,
  BISS_VERDICT_FAILED,
  BISS_VERDICT_SELF_TEST,
  BISS_VERDICT_MEMORY,
  BISS_VERDICT_DISAGREEMENT,
  BISS_VERDICT_CLOCK,
  BISS_VERDICT_WATCHDOG,
  BISS_VERDICT_EARLY,
  BISS_VERDICT_NO_FRAME,
  BISS_VERDICT_CPW_CRC,
  BISS_VERDICT_SPW_CRC,
  BISS_VERDICT_CPW_ERROR,
  BISS_VERDICT_SPW_ERROR,
  BISS_VERDICT_COMPARISON,
  BISS_VERDICT_COUNTER_MODE,
  BISS_VERDICT_COUNTER_REPEATED,
  BISS_VERDICT_COUNTER_SKIPPED,
  BISS_VERDICT_COUNTER_BACKWARDS,
  BISS_VERDICT_COUNTER_FOREIGN,
  BISS_VERDICT_COUNTER_FIRST,
  BISS_VERDICT_STIMULUS,
  BISS_VERDICT_INVALID /* a fault of the memory: treat it as a fault of the receiver */
} biss_verdict;

/* The name in the output of `biss decode`: "safe", "watchdog", …; "invalid" for any other
 * number. */
const char* biss_verdict_name(biss_verdict verdict);

/* Two independent clocks, read at the same moment, and the SPI transfer as the clock measured it
 * (used only if bit_period_ps is set). With one clock, second_ps is now_ps. */
typedef struct biss_safety_time {
  int64_t now_ps;
  int64_t second_ps;
  int64_t transfer_ps;
} biss_safety_time;

/* No position: no word of an encoder has that many bits. */
#define BISS_NO_POSITION UINT64_MAX

typedef struct biss_judgement {
  biss_verdict verdict;
  const char* state; /* after this frame: "untested", "starting", "safe", "latched", "failed" */
  bool tolerated;    /* the fault is within the budget */
  bool cpw_nW;
  bool spw_nW;
  uint32_t life_counter;
  int32_t difference_lsb; /* CPW minus SPW in counts of the lowest bit compared */
  /* Valid only if the verdict of biss_safety_step() is safe. Otherwise all members from here on are
   * 0, or BISS_NO_POSITION if the verdict is safe without a frame, from biss_safety_watch(). */
  bool has_position;
  uint64_t position; /* in counts of the SPW, turns above singleturn */
  uint64_t low;      /* the least and the largest position if one of the words is wrong */
  uint64_t high;
  uint64_t control_position; /* in counts of the CPW: for motion control, not for safety */
} biss_judgement;

/* Judges the answer to one request: bits `first_bit` to `first_bit` + `bit_count` - 1 of `bytes`,
 * as biss_frame_decode(); none if there was no answer. After a status that is not BISS_OK the
 * frame was not judged, and no position may be used.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_safety_step(biss_safety* safety, const biss_safety_time* time,
                             const uint8_t* bytes, size_t byte_count, size_t first_bit,
                             size_t bit_count, biss_judgement* judgement);

/* Checks the time only, at biss_safety_deadline() or in a tick. It never has a position: with the
 * verdict safe, which means that the last good frame is still in time, every position is
 * BISS_NO_POSITION. Errors as above. */
biss_status biss_safety_watch(biss_safety* safety, const biss_safety_time* time,
                              biss_judgement* judgement);

/* The last moment of the first clock at which the watchdog is satisfied; *is_expected false: no
 * frame is expected. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_safety_deadline(const biss_safety* safety, bool* is_expected,
                                 int64_t* deadline_ps);

/* The next good frame must have its position from `low` to `high`, in counts of the SPW; `low` may
 * be above `high`, across the wrap-around. Nothing but a good frame ends the expectation. A position
 * outside is BISS_VERDICT_STIMULUS, of this frame and of every further good one until
 * biss_safety_encoder_restarted(). BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_safety_expect(biss_safety* safety, uint64_t low, uint64_t high);

/* Clears the latched fault with this cause.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_NO_READING: another fault, or none, is latched. */
biss_status biss_safety_acknowledge(biss_safety* safety, biss_verdict cause);

/* The cause of the fault that holds.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_NO_READING: no fault holds. */
biss_status biss_safety_cause(const biss_safety* safety, biss_verdict* cause);

/* After the encoder was switched off or exchanged, before its first request and, with counter_first,
 * after biss_safety_acknowledge(): the counter's place is forgotten, and the faults counter_first and
 * stimulus end. Clears no latched fault, and keeps the budget of faults and an expectation.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_safety_encoder_restarted(biss_safety* safety);

BISS_C_END
