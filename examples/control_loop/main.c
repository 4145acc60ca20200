/* A control loop on Linux: every cycle reads an encoder at an SPI port, computes a controller, and
 * has a deadline. It prints its latencies, missed deadlines and causes at the end.
 *
 *   control_loop DEVICE FORMAT CLOCK_HZ CYCLE_US CYCLES MAX_STEP [log]
 *
 * MAX_STEP: the largest movement in one cycle and an eighth, in counts. With `log` it prints number,
 * cause and position of the first LOG_MAX cycles. docs/read.md has the command that compiles it. */
#include <inttypes.h>
#include <sched.h>
#include <signal.h>
#include <spidev_axis.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#define BUCKETS 16 /* below 1 us, below 2 us, below 4 us, … */
#define LOG_MAX 100000

typedef struct histogram {
  uint64_t buckets[BUCKETS];
  int64_t max_ns;
} histogram;

static void histogram_add(histogram* h, int64_t time_ns) {
  int bucket = 0;
  while (bucket < BUCKETS - 1 && time_ns >= INT64_C(1000) << bucket) ++bucket;
  ++h->buckets[bucket];
  if (time_ns > h->max_ns) h->max_ns = time_ns;
}

static void histogram_print(const histogram* h, const char* name) {
  printf("%-9s at most %" PRId64 " us:", name, h->max_ns / 1000);
  for (int i = 0; i < BUCKETS - 1; ++i) {
    if (h->buckets[i]) printf(" %" PRIu64 " below %" PRId64 " us,", h->buckets[i], INT64_C(1) << i);
  }
  printf(" %" PRIu64 " above\n", h->buckets[BUCKETS - 1]);
}

/* Yours. Here a spring to position 0 with a damper, limited to ± 1000. */
static int64_t control(const biss_axis_position* now) {
  const int64_t force = -now->position / 4096 - now->step / 256;
  return force > 1000 ? 1000 : force < -1000 ? -1000 : force;
}

static volatile sig_atomic_t ended;
static void end(int signal) { ended = signal; }

/* All memory, also later pages, stays in RAM; the program precedes all that is not real-time. */
static void become_real_time(void) {
  const struct sched_param priority = {.sched_priority = 80};
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0 ||
      sched_setscheduler(0, SCHED_FIFO, &priority) != 0) {
    fputs("no right to SCHED_FIFO, so cycles may be late: run as root, or see limits.conf\n",
          stderr);
  }
}

static spidev_axis axis;
static biss_axis_position records[LOG_MAX];

int main(int count, char** words) {
  if (count < 7 || count > 8) {
    fprintf(stderr, "usage: control_loop DEVICE FORMAT CLOCK_HZ CYCLE_US CYCLES MAX_STEP [log]\n");
    return 2;
  }
  const int64_t cycle_ns = strtoll(words[4], NULL, 10) * 1000;
  const uint64_t cycles = strtoull(words[5], NULL, 10);
  const uint32_t clock_hz = (uint32_t)strtoul(words[3], NULL, 10);
  const char* wrong =
      spidev_axis_open(&axis, words[1], words[2], clock_hz, 2000000, strtoll(words[6], NULL, 10));
  if (wrong == NULL && spidev_axis_begin(&axis, cycle_ns * 1000) != BISS_OK)
    wrong = "impossible cycle";
  if (wrong != NULL) {
    fprintf(stderr, "control_loop: %s: %s\n", words[1], wrong);
    return 1;
  }
  become_real_time();
  signal(SIGINT, end);
  signal(SIGTERM, end);

  histogram wake_up = {0}, response = {0};
  uint64_t missed = 0, done = 0;
  int64_t output = 0, due = spidev_axis_now_ns() + cycle_ns;
  for (; done < cycles && !ended; ++done) {
    const struct timespec until = {due / 1000000000, due % 1000000000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR && !ended) {
    }
    histogram_add(&wake_up, spidev_axis_now_ns() - due);
    biss_axis_position now;
    spidev_axis_cycle(&axis, &now);
    output = now.usable ? control(&now) : 0; /* tripped: stop the drive */
    if (done < LOG_MAX) records[done] = now;

    const int64_t took = spidev_axis_now_ns() - due;
    histogram_add(&response, took);
    /* The deadline is the begin of the next cycle. Cycles that have passed are not made up for. */
    const int64_t passed = took / cycle_ns;
    missed += (uint64_t)passed;
    due += (passed + 1) * cycle_ns;
  }

  for (uint64_t i = 0; count > 7 && i < done && i < LOG_MAX; ++i) {
    printf("%" PRIu32 " %s %" PRId64 "\n", records[i].number,
           biss_axis_cause_name(records[i].cause), records[i].position);
  }
  printf("cycles    %" PRIu64 ", last output %" PRId64 "\n", done, output);
  histogram_print(&wake_up, "wake-up");
  histogram_print(&response, "response");
  printf("deadlines %" PRIu64 " missed\n", missed);
  for (biss_axis_cause cause = BISS_AXIS_OK; cause <= BISS_AXIS_UNEXPECTED; ++cause) {
    const uint32_t times = biss_axis_count(&axis.axis, cause);
    if (times) printf("cause     %s %" PRIu32 "\n", biss_axis_cause_name(cause), times);
  }
  return 0;
}
